"""Incremental decoding of a progressive GLB."""

from __future__ import annotations

import contextlib
import copy
import itertools
import pickle
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tristrip
from test_stream import BYTES, hills

Find = Callable[[str], Path]


def in_pieces(data: bytes, size: int) -> Iterator[bytes]:
    """Split bytes into pieces."""
    return (data[start : start + size] for start in range(0, len(data), size))


def whole(data: bytes) -> tristrip.Decoder:
    decoder = tristrip.Decoder()
    decoder.update(data)
    return decoder


def test_byte_by_byte_equals_the_whole() -> None:
    decoder = tristrip.Decoder(strips=True)
    chunks = 0
    levels = []
    for at, piece in enumerate(in_pieces(BYTES, 1)):
        assert decoder.offset == at
        chunks += decoder.update(piece)
        levels.append(decoder.level)
        if decoder.chunk_start is not None:
            assert decoder.has_base == (decoder.offset >= decoder.chunk_start)
    assert levels == sorted(levels)
    assert decoder.is_complete
    assert chunks == decoder.chunk_count == len(tristrip.inspect(BYTES)["chunks"])
    decoder.finish()
    (part,), (expected,) = decoder.parts, whole(BYTES).parts
    assert part.fingerprint == expected.fingerprint
    assert (part.vertices == expected.vertices).all()
    assert (part.faces == expected.faces).all()
    part.strips().verify(part.faces)


@given(st.lists(st.integers(0, len(BYTES)), max_size=8))
def test_any_split_of_the_bytes_gives_the_same(cuts: list[int]) -> None:
    ends = [0, *sorted(cuts), len(BYTES)]
    decoder = tristrip.Decoder()
    for start, end in itertools.pairwise(ends):
        decoder.update(BYTES[start:end])
    assert decoder.parts[0].fingerprint == whole(BYTES).parts[0].fingerprint


def test_the_full_mesh_is_that_of_unpack(model: Find) -> None:
    data = tristrip.pack(model("hand.ply")).bytes
    unpacked = tristrip.unpack(data)
    (part,) = whole(data).parts
    assert part.level == part.full_level
    assert part.triangle_count == part.full_triangle_count
    assert part.vertex_count == part.full_vertex_count == len(unpacked.vertices)
    # The same vertices in the same order, so the triangles are also equal.
    assert sorted(map(tuple, part.vertices.tolist())) == sorted(map(tuple, unpacked.vertices.tolist()))
    drawn = np.sort(part.vertices[part.faces].reshape(-1, 9), axis=0)
    assert (drawn == np.sort(unpacked.vertices[unpacked.faces].reshape(-1, 9), axis=0)).all()
    assert part.position_bits == 14


def test_each_state_is_a_mesh_and_errors_fall() -> None:
    counts, errors, last = [], [], None
    for decoder in tristrip.decode(in_pieces(BYTES, 400)):
        last = decoder.error
        for part in decoder.parts:
            assert part.faces.shape == (part.triangle_count, 3)
            assert part.vertices.shape == (part.vertex_count, 3)
            assert part.faces.max() < part.vertex_count
            counts.append(part.triangle_count)
            errors.append(part.error)
    assert counts == sorted(counts)
    assert counts[0] < counts[-1] == 1682
    assert errors[-1] < errors[0] / 10
    assert last == errors[-1]


def test_a_scene_has_attributes_and_parts(model: Find) -> None:
    data = tristrip.pack(model("milktruck.glb")).bytes
    decoder = whole(data)
    assert decoder.is_complete
    for part in decoder.parts:
        assert {"NORMAL"} <= set(part.attributes)
        assert all(len(values) == part.vertex_count for values in part.attributes.values())
        assert np.isfinite(part.attributes["NORMAL"]).all()


def test_a_file_without_a_stream_is_complete_at_its_end() -> None:
    data = tristrip.pack(hills(2), format="obj").bytes
    decoder = tristrip.Decoder()
    for piece in in_pieces(data, 1):
        assert not decoder.is_complete
        decoder.update(piece)
    assert decoder.is_complete
    assert decoder.parts == []
    assert decoder.error is None
    assert decoder.chunk_start is None


def test_bytes_that_end_early_are_told() -> None:
    states = tristrip.decode([BYTES[: len(BYTES) // 2]])
    assert next(states).triangle_count > 0
    with pytest.raises(tristrip.FormatError, match=r"the end of the file after"):
        next(states)
    decoder = list(tristrip.decode([BYTES[: len(BYTES) // 2]], partial=True))[-1]
    assert not decoder.is_complete
    assert decoder.triangle_count > 0
    # Decoding continues from there.
    decoder.update(BYTES[decoder.offset :])
    assert decoder.is_complete


@pytest.mark.parametrize("at", [0, 3, 5, 17, 30, -600, -20])
def test_damage_is_told_and_what_came_before_stays(at: int) -> None:
    damaged = bytearray(BYTES)
    damaged[at] ^= 0x55
    decoder = tristrip.Decoder()
    with pytest.raises(tristrip.FormatError) as first:
        list(tristrip.decode([damaged]))
    with contextlib.suppress(tristrip.FormatError):
        decoder.update(damaged)
    triangles = decoder.triangle_count
    assert (triangles > 0) == (at < 0)
    for use in (lambda: decoder.update(BYTES), lambda: decoder.update(b""), decoder.finish):
        with pytest.raises(tristrip.FormatError) as again:
            use()
        assert str(again.value) == str(first.value)
    assert decoder.triangle_count == triangles


@given(st.integers(0, len(BYTES) - 1), st.integers(1, 255), st.integers(1, 2000))
def test_damaged_bytes_do_no_harm(at: int, change: int, size: int) -> None:
    damaged = bytearray(BYTES)
    damaged[at] ^= change
    decoder = tristrip.Decoder(strips=True)
    try:
        for piece in in_pieces(bytes(damaged), size):
            decoder.update(piece)
    except (tristrip.FormatError, tristrip.LimitError):
        pass
    for part in decoder.parts:
        assert part.faces.max(initial=0) < max(part.vertex_count, 1)


def test_limits_are_kept() -> None:
    with pytest.raises(tristrip.LimitError, match=r"bytes before the first chunk: found .*, the limit is 100"):
        tristrip.Decoder(max_bytes=100).update(BYTES)
    with pytest.raises(tristrip.LimitError, match=r"triangles: found 1[0-9]+, the limit is 1000"):
        tristrip.Decoder(max_triangles=1000).update(BYTES)
    # A document may declare any length; nothing is allocated for it.
    header = b"glTF" + (2).to_bytes(4, "little") + b"\xff" * 8 + b"JSON"
    with pytest.raises(tristrip.LimitError):
        tristrip.Decoder().update(header)
    for name in ("max_bytes", "max_triangles"):
        with pytest.raises(tristrip.ParameterError, match=r"found -1, expected a count of 0 or more"):
            tristrip.Decoder(**{name: -1})  # type: ignore[arg-type]


def test_arguments_are_bytes() -> None:
    decoder = tristrip.Decoder()
    for wrong in ("glTF", 5, None, [1, 2]):
        with pytest.raises(tristrip.ArrayTypeError, match=r"data: found .*, expected bytes"):
            decoder.update(wrong)  # type: ignore[arg-type]
    for piece in (bytearray(BYTES[:50]), memoryview(BYTES)[50:100], np.frombuffer(BYTES[100:], np.uint8)):
        decoder.update(piece)  # type: ignore[arg-type]
    assert decoder.is_complete
    decoder.update(b"more")
    assert decoder.is_complete
    assert decoder.offset == len(BYTES) + 4
    with pytest.raises(tristrip.ParameterError, match=r"strips: found False, expected True in the decoder"):
        decoder.parts[0].strips()


def test_copies_go_on_by_themselves() -> None:
    decoder = tristrip.Decoder()
    decoder.update(BYTES[:4000])
    other = copy.copy(decoder)
    third = copy.deepcopy(decoder)
    decoder.update(BYTES[4000:])
    assert decoder.is_complete
    assert not other.is_complete
    assert not third.is_complete
    other.update(BYTES[4000:])
    assert other.parts[0].fingerprint == decoder.parts[0].fingerprint
    with pytest.raises(TypeError):
        pickle.dumps(decoder)
    assert repr(decoder).startswith("Decoder(1,682 of 1,682 triangles, ")
    assert repr(decoder.parts[0]).startswith("StreamedPart(mesh 0, 1,682 of 1,682 triangles, error ")
    assert "<table>" in decoder._repr_html_()


def test_threads_may_look_while_bytes_arrive() -> None:
    decoder = tristrip.Decoder()
    stop = threading.Event()
    problems: list[BaseException] = []

    def look() -> None:
        try:
            while not stop.is_set():
                for part in decoder.parts:
                    assert part.faces.max() < len(part.vertices)
        except (AssertionError, RuntimeError) as problem:
            problems.append(problem)

    threads = [threading.Thread(target=look) for _ in range(3)]
    for thread in threads:
        thread.start()
    for piece in in_pieces(BYTES, 7):
        decoder.update(piece)
    stop.set()
    for thread in threads:
        thread.join()
    assert problems == []
    assert decoder.is_complete

"""Ctrl-C for tests."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Generator
from contextlib import contextmanager


@contextmanager
def interrupt_after(seconds: float) -> Generator[None]:
    """Send SIGINT to this process during the body, and wait for it."""
    sent = threading.Event()

    def send() -> None:
        time.sleep(seconds)
        os.kill(os.getpid(), signal.SIGINT)
        sent.set()

    thread = threading.Thread(target=send)
    thread.start()
    try:
        yield
        sent.wait()
        time.sleep(0.01)
    finally:
        thread.join()

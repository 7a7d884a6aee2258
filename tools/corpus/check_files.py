#!/usr/bin/env python3
"""Checks many files with a checker for single files, one process per core.

    check_files.py CHECKER LIST

CHECKER: a Python program. Its main([source, result]) returns 0 if the result draws the same as the source, and its
read(path) reads a model. LIST: one line per pair: source, tab, result. A source is read once per run of results.
Exits with 0 if every file passes, with 1 otherwise.
"""
import contextlib, functools, importlib.util, io, itertools, multiprocessing, os, sys

RUN = 6  # results checked per reading of their source


def start(checker):
    """Loads the checker into this process, with a reader that caches the source."""
    global check
    spec = importlib.util.spec_from_file_location('checker', checker)
    check = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(check)
    read = check.read
    cached = functools.lru_cache(maxsize=1)(read)
    check.read = lambda path: cached(path) if path == start.source else read(path)


def prove(run):
    """Returns the number of results of a run, and a line per failure."""
    source, results = run
    start.source, problems = source, []
    for result in results:
        output = io.StringIO()
        try:
            with contextlib.redirect_stdout(output):
                code = check.main([source, result, '--json'])
        except (Exception, SystemExit) as error:
            code, output = 2, io.StringIO(f'{type(error).__name__}: {error}')
        if code:
            problems.append(f'{os.path.basename(result)}: {output.getvalue().strip()[:400]}')
    return len(results), problems


def main(checker, listed):
    with open(listed) as lines:
        pairs = sorted(line.rstrip('\n').split('\t') for line in lines)
    runs = []
    for source, group in itertools.groupby(pairs, key=lambda pair: pair[0]):
        results = [pair[1] for pair in group]
        runs += [(source, results[i:i + RUN]) for i in range(0, len(results), RUN)]
    runs.sort(key=lambda run: -sum(map(os.path.getsize, run[1])))
    proven = failed = 0
    with multiprocessing.Pool(initializer=start, initargs=(checker,)) as pool:
        for count, problems in pool.imap_unordered(prove, runs):
            for problem in problems:
                print('not proven:', problem, file=sys.stderr)
            proven, failed = proven + count - len(problems), failed + len(problems)
    print(f'checker: {proven} files proven, {failed} not')
    return 1 if failed or not proven else 0


if __name__ == '__main__':
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))

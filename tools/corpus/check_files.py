#!/usr/bin/env python3
"""Proves many files by a checker of single files, one process a core.

    check_files.py CHECKER LIST

CHECKER: a Python program whose main([source, result]) returns 0 where the result draws what the source does, and whose
read(path) reads a model. LIST: lines of source, tab, result. Sources are read once for a run of results.
Exit 0 where every file is proven, 1 where one is not.
"""
import contextlib, functools, importlib.util, io, itertools, multiprocessing, os, sys

RUN = 6  # results that are checked with one reading of their source


def start(checker):
    """Loads the checker into this process, its reader with a memory for the source."""
    global check
    spec = importlib.util.spec_from_file_location('checker', checker)
    check = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(check)
    read = check.read
    remembered = functools.lru_cache(maxsize=1)(read)
    check.read = lambda path: remembered(path) if path == start.source else read(path)


def prove(run):
    """Gives a line for each result of a run that is not proven."""
    source, results = run
    start.source, faults = source, []
    for result in results:
        said = io.StringIO()
        try:
            with contextlib.redirect_stdout(said):
                code = check.main([source, result, '--json'])
        except (Exception, SystemExit) as error:
            code, said = 2, io.StringIO(f'{type(error).__name__}: {error}')
        if code:
            faults.append(f'{os.path.basename(result)}: {said.getvalue().strip()[:400]}')
    return len(results), faults


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
        for count, faults in pool.imap_unordered(prove, runs):
            for fault in faults:
                print('not proven:', fault, file=sys.stderr)
            proven, failed = proven + count - len(faults), failed + len(faults)
    print(f'checker: {proven} files proven, {failed} not')
    return 1 if failed or not proven else 0


if __name__ == '__main__':
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))

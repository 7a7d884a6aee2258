"""The command-line program: `tristrip`, or `python -m tristrip`."""

from __future__ import annotations

import signal
import sys

from ._native import run_command


def main() -> int:
    """Run the command with the arguments of the process, and return its exit code."""
    # Let Ctrl-C end the process, as in any command. The program changes this during searches.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.stdout.flush()
    return run_command(["tristrip", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())

# What `run` and `night` share: the environment, stages, and the checker of files. Sourced by bash.
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit 1
shared=$(cd .. && pwd)/shared
if [ ! -d "$shared/models" ] || [ ! -f "$shared/check_strips.py" ]; then
    echo "ci: ../shared is missing: expected the models in ../shared/models and the checker ../shared/check_strips.py" >&2
    exit 1
fi
mkdir -p "${CARGO_TARGET_DIR:-target}"
target=$(cd "${CARGO_TARGET_DIR:-target}" && pwd)
export TRISTRIP_MODELS="$shared/models" CARGO_TERM_COLOR=never CARGO_INCREMENTAL=0
# What would be skipped fails.
export TRISTRIP_REQUIRE_VALIDATOR=1 TRISTRIP_REQUIRE_BROWSER=1 TRISTRIP_REQUIRE_PYTHON=1
passed=0 failed=0 failures=

# Runs a command as a stage: prints its name and time, and goes on when it fails.
stage() {
    local name=$1 start=$SECONDS
    shift
    echo "== $name"
    if "$@"; then
        passed=$((passed + 1))
        echo "== $name: passed in $((SECONDS - start)) s"
    else
        failed=$((failed + 1)) failures+=$'\n'"  $name"
        echo "== $name: FAILED after $((SECONDS - start)) s"
    fi
}

# Prints which stages failed and how many passed, and exits.
finish() {
    [ -z "$failures" ] || echo "== failed:$failures"
    echo "$passed passed, $failed failed"
    [ "$failed" -eq 0 ]
    exit
}

# Checks models of the corpus: `corpus FOLDER OPTIONS…`. The files are read again by a checker in Python.
corpus() {
    local python=$target/venv/bin/python
    [ -x "$python" ] || python3 -m venv "$target/venv" || return 1
    "$python" -c 'import numpy' 2>/dev/null || "$python" -m pip install --quiet 'numpy>=2,<3' || return 1
    "$target/$1/corpus" "$shared/models" --checker "$shared/check_strips.py" --python "$python" "${@:2}"
}

#!/usr/bin/env bash
# Checks that the crates which hosts embed compile for each target, and says what it could not check:
#
#     tests/targets.sh [TARGET...]
#
# `cargo check` neither links nor runs anything. So a pass says that the code of a target compiles; tests run on Linux.
#
# A target needs its standard library. There are two ways to have it:
#   rustup target add aarch64-apple-darwin aarch64-linux-android wasm32-unknown-unknown x86_64-pc-windows-gnu
#   CROSS_RUSTC=/path/to/rustc   a Rust with rust-src, whose standard library is then built for each target. Debian's
#                                packages rustc-web and rust-web-src are one, and so is a nightly with rust-src.
# The second way needs a dlltool for Windows: that of Debian's binutils-mingw-w64-x86-64, or DLLTOOL=/path/to/it.
#
# Exit status: 0 if every target was checked and compiles, 1 if one does not compile, 2 if one was not checked.
# All five take about a quarter of an hour on two free cores.
set -uo pipefail
cd "$(dirname "$0")/.."

crates=(afterimage)
targets=("$@")
[ ${#targets[@]} -gt 0 ] || targets=(
    x86_64-unknown-linux-gnu x86_64-pc-windows-gnu aarch64-apple-darwin aarch64-linux-android wasm32-unknown-unknown
)
# Artifacts of another Rust must not replace those of the tests.
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-target}/targets
sysroot=$(rustc --print sysroot)
logs=$(mktemp -d)
trap 'rm -rf "$logs"' EXIT

has_std() { compgen -G "$sysroot/lib/rustlib/$1/lib/libstd-*" > /dev/null; }

dlltool() {
    if [ -n "${DLLTOOL:-}" ]; then echo "$DLLTOOL"; else command -v x86_64-w64-mingw32-dlltool; fi
}

packages=()
for crate in "${crates[@]}"; do packages+=(-p "$crate"); done

# Prints what came of a target; 0 if it compiles, 1 if not, 2 if it was not checked.
check_target() {
    local target=$1 build_std=() rust="the Rust of cargo"
    if ! has_std "$target"; then
        if [ -z "${CROSS_RUSTC:-}" ]; then
            echo "not checked: its standard library is not installed, and CROSS_RUSTC is not set"
            return 2
        fi
        if [[ $target == *-windows-gnu ]] && ! dlltool > /dev/null; then
            echo "not checked: there is no x86_64-w64-mingw32-dlltool, and DLLTOOL is not set"
            return 2
        fi
        build_std=(-Zbuild-std=std,panic_abort)
        rust="CROSS_RUSTC, standard library built"
        export RUSTC=$CROSS_RUSTC RUSTC_BOOTSTRAP=1
        [[ $target != *-windows-gnu ]] || export RUSTFLAGS="-Cdlltool=$(dlltool)"
    fi
    # On the web, the viewer's page is what runs.
    local page=()
    [[ $target != wasm32-* ]] || page=(-p afterimage-view --features afterimage-view/page)
    if cargo check "${build_std[@]}" --target "$target" "${packages[@]}" "${page[@]}" > "$logs/$target" 2>&1; then
        echo "compiles ($rust)"
    else
        echo "DOES NOT COMPILE ($rust): $(grep -c '^error' "$logs/$target") errors, of which the first is"
        grep -m 1 -A 12 '^error' "$logs/$target"
        return 1
    fi
}

echo "cargo check of ${crates[*]}, without linking and running:"
status=0
for target in "${targets[@]}"; do
    result=$(check_target "$target")
    came=$?
    printf '%-28s %s\n' "$target" "$result"
    # One that does not compile outweighs one that was not checked.
    if [ $came -eq 1 ] || [ $status -eq 0 ]; then status=$came; fi
done
exit $status

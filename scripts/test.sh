#!/usr/bin/env bash
# Checks this working tree the way CI does: format, lints, all tests, one example drawn without a window.
#
# What it costs. Clippy compiles every dependency as metadata only, `cargo test` compiles them again with code, because
# cargo does not reuse one for the other (rust-lang/cargo#3501). Only build scripts, procedural macros and what these
# depend on are shared. So a run from nothing pays for Bevy twice, minutes each on two cores; the metadata pass is the
# shorter one and comes first, so a lint error shows before the long build. A second run recompiles only what changed.
# `cargo test` also builds the examples, so the last step should compile nothing: all commands see the same packages
# (`default-members` lists the workspace) and so the same features and the same one build of wgpu.
# The test binaries run two at a time, where `cargo test` runs one after the other: the last test of each is one thread that
# leaves the other cores idle. Every binary that cargo builds is run; only the order is said here.
# Therefore no `-p`, no `--release`, no `--features` and no RUSTFLAGS where there is code to make: each would build wgpu and Bevy
# once more. Clippy shares none of that, so it alone has the lab's feature `peers`, which nothing else here compiles: nine packages
# more (salva3d with its own nalgebra and glam), 16 s of one core, and the same build scripts and procedural macros. The
# lab without it is what the tests are built of. A clippy by hand without the feature checks Bevy once for itself in the same folder.
set -euo pipefail

driver_install='apt-get update && apt-get install -y mesa-vulkan-drivers libvulkan1'
# Catches an empty or cut-off picture. Whether the picture is right is for the golden tests in tests/it.
least_picture_bytes=8192

usage() {
    cat <<'HELP'
Usage: scripts/test.sh [--install] [--help]

Runs the format check, clippy, all tests and the dam_break example without a window.
A GPU is not needed, but a Vulkan driver is (Linux); a software driver will do.

  --install   install a software Vulkan driver first if none is usable (Debian, Ubuntu)
  --help      show this text

CARGO_TARGET_DIR is respected; a relative one counts from the repository's root.
HELP
}

install_driver=false
for argument in "$@"; do
    case $argument in
        --install) install_driver=true ;;
        --help | -h) usage; exit 0 ;;
        *) printf 'unknown argument: %s\n\n' "$argument" >&2; usage >&2; exit 2 ;;
    esac
done

cd "$(dirname "${BASH_SOURCE[0]}")/.."
export CARGO_INCREMENTAL=0

scratch=$(mktemp -d)
current_step='start'
finish() {
    local status=$?
    rm -rf "$scratch"
    if ((status == 0)); then
        printf '[%4ds] all checks passed\n' "$SECONDS"
    else
        printf '[%4ds] FAILED in: %s\n' "$SECONDS" "$current_step" >&2
    fi
}
trap finish EXIT
# Otherwise a signal would skip straight past the cleaning up.
trap 'exit 129' HUP
trap 'exit 130' INT
trap 'exit 141' PIPE
trap 'exit 143' TERM

step() {
    current_step=$1
    printf '[%4ds] %s\n' "$SECONDS" "$current_step"
}

fail() {
    printf '%s\n' "$*" >&2
    exit 1
}

# --- Vulkan ---------------------------------------------------------------------------------------------------------
# Decided from files, so that vulkan-tools is not needed.

has_loader() {
    local listing folder folders
    # sbin is not on every user's path. No pipe into grep: with pipefail its early exit would count as a failure.
    listing=$(PATH="$PATH:/sbin:/usr/sbin" ldconfig -p 2>/dev/null) || listing=''
    [[ $listing == *libvulkan.so.1* ]] && return 0
    IFS=: read -r -a folders <<<"${LD_LIBRARY_PATH:-}:/usr/lib:/usr/lib64:/usr/local/lib"
    for folder in "${folders[@]}"; do
        [[ -n $folder && -e $folder/libvulkan.so.1 ]] && return 0
    done
    return 1
}

# Mesa installs drivers for GPUs that are not there, so a driver's file alone proves nothing.
has_gpu_device() {
    local device
    for device in /dev/dri/renderD* /dev/nvidia[0-9]* /dev/dxg; do
        [[ -r $device && -w $device ]] && return 0
    done
    return 1
}

is_usable_driver() {
    [[ -r $1 ]] || return 1
    case ${1##*/} in
        lvp_icd*.json | *swiftshader*.json) return 0 ;;
        *.json) has_gpu_device ;;
        *) return 1 ;;
    esac
}

# The loader looks nowhere else once one of these is set; VK_DRIVER_FILES is the newer name and wins.
named_drivers() {
    printf '%s' "${VK_DRIVER_FILES:-${VK_ICD_FILENAMES:-}}"
}

has_driver() {
    local entry entries file
    if [[ -n $(named_drivers) ]]; then
        IFS=: read -r -a entries <<<"$(named_drivers)"
    else
        entries=(/usr/share/vulkan/icd.d /usr/local/share/vulkan/icd.d /etc/vulkan/icd.d
            "${XDG_DATA_HOME:-${HOME:-}/.local/share}/vulkan/icd.d")
    fi
    for entry in "${entries[@]}"; do
        if [[ -d $entry ]]; then
            for file in "$entry"/*.json; do
                is_usable_driver "$file" && return 0
            done
        elif is_usable_driver "$entry"; then
            return 0
        fi
    done
    return 1
}

has_adapter() {
    case $(uname -s) in
        Darwin | MINGW* | MSYS* | CYGWIN*) return 0 ;; # Metal and DX12 come with the system.
    esac
    has_loader && has_driver
}

is_debian() {
    local family=''
    [[ -r /etc/os-release ]] || return 1
    # shellcheck source=/dev/null
    family=$(. /etc/os-release && printf ' %s %s ' "${ID:-}" "${ID_LIKE:-}")
    [[ $family == *' debian '* || $family == *' ubuntu '* ]] && command -v apt-get >/dev/null
}

as_root() {
    if ((EUID == 0)); then
        "$@"
    elif command -v sudo >/dev/null; then
        sudo "$@"
    else
        fail "no Vulkan adapter, and neither root nor sudo to install one. As root: $driver_install"
    fi
}

ensure_adapter() {
    has_adapter && return
    if [[ -n $(named_drivers) ]]; then
        fail "no Vulkan adapter: VK_DRIVER_FILES or VK_ICD_FILENAMES names no usable driver, or libvulkan.so.1 is missing"
    fi
    if ! $install_driver; then
        fail "no Vulkan adapter: run with --install, or as root: $driver_install"
    fi
    if ! is_debian; then
        fail "no Vulkan adapter, and --install knows Debian and Ubuntu only. Install the Vulkan loader and Mesa's lavapipe:
  Fedora    mesa-vulkan-drivers vulkan-loader
  Arch      vulkan-swrast vulkan-icd-loader
  openSUSE  libvulkan_lvp libvulkan1
  Alpine    mesa-vulkan-swrast vulkan-loader"
    fi
    as_root apt-get update
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y mesa-vulkan-drivers libvulkan1
    has_adapter || fail "no Vulkan adapter, even after: $driver_install"
}

step 'Vulkan adapter'
command -v cargo >/dev/null || fail 'cargo is not on the path: install Rust from https://rustup.rs'
ensure_adapter

# Vulkan and window libraries complain, some fail, without a runtime folder of their own.
if [[ -z ${XDG_RUNTIME_DIR:-} || ! -d $XDG_RUNTIME_DIR || ! -w $XDG_RUNTIME_DIR ]]; then
    mkdir -m 700 "$scratch/runtime"
    export XDG_RUNTIME_DIR="$scratch/runtime"
fi

# --- Checks ---------------------------------------------------------------------------------------------------------

step 'cargo fmt --all --check'
cargo fmt --all --check

step 'cargo clippy --workspace --all-targets --features freshet_lab/peers -- -D warnings'
cargo clippy --workspace --all-targets --features freshet_lab/peers -- -D warnings

step 'cargo test --workspace --no-run'
cargo test --workspace --no-run

# Lines of a package's folder, a tab, and a test binary of it; those that take longest first, so that they end with the others.
test_binaries() {
    cargo test --workspace --no-run --quiet --message-format=json >"$scratch/messages"
    <"$scratch/messages" sed -n '/"test":true},"features"/s/.*"manifest_path":"\([^"]*\)\/Cargo.toml".*"executable":"\([^"]*\)".*/\1'$'\t''\2/p' |
        awk '{ print /\/column-[^\/]*$/ ? 0 : /\/float-[^\/]*$/ ? 1 : /\/it-[^\/]*$/ ? 2 : 3, $0 }' | sort -s -n -k1,1 | cut -d ' ' -f 2-
}

# What it says is shown in one piece, and only if it fails.
run_tests() {
    local folder=${1%%$'\t'*} binary=${1#*$'\t'} log begin=$SECONDS
    log="$scratch/$(basename "$binary").log"
    if (cd "$folder" && CARGO_MANIFEST_DIR="$folder" "$binary") >"$log" 2>&1; then
        printf '%5d s  %-28s %s\n' $((SECONDS - begin)) "$(basename "${binary%-*}")" "$(grep '^test result' "$log")"
    else
        cat "$log"
        printf 'FAILED: %s\n' "$binary"
        return 1
    fi
}
export -f run_tests
export scratch

step 'tests'
test_binaries >"$scratch/binaries"
# Counted in another way, so that none is dropped in silence when cargo's messages change.
named=$(grep '"profile":{[^}]*"test":true' "$scratch/messages" | grep -c '"executable":"')
[[ $named -gt 0 && $(wc -l <"$scratch/binaries") -eq $named ]] || fail "not all of the $named test binaries that cargo names were found"
# Mesa's software driver: in the calling thread. Its own threads are of use to nobody while tests run side by side.
tr '\n' '\0' <"$scratch/binaries" | LP_NUM_THREADS=0 xargs -0 -n 1 -P 2 bash -c 'run_tests "$1"' run_tests ||
    fail 'a test failed, see above'

step 'cargo test --workspace --doc'
cargo test --workspace --doc

step 'cargo run --example dam_break (headless)'
out="$scratch/dam_break"
mkdir "$out"
cargo run --example dam_break -- --headless --particles 8000 --seconds 0.5 --pictures 4 --out "$out"

is_picture() {
    local size signature
    size=$(wc -c <"$1")
    signature=$(od -An -tx1 -N8 "$1" | tr -d ' \n')
    [[ $signature == 89504e470d0a1a0a ]] && ((size >= least_picture_bytes))
}

has_picture=false
while IFS= read -r file; do
    if is_picture "$file"; then has_picture=true; fi
done < <(find "$out" -type f -name '*.png')
$has_picture || fail "the example left no PNG of $least_picture_bytes bytes or more; it left: $(ls -R "$out")"

summary=$(find "$out" -type f -name 'summary.*' -size +0c)
[[ -n $summary ]] || fail "the example left no summary.*, or an empty one; it left: $(ls -R "$out")"

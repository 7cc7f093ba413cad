# For the scripts beside it, which source it from the root of the project.

# need_ict: ICT_FACEKIT has to name the folder with ICT-FaceKit's FaceXModel.
need_ict() {
    if [ ! -d "${ICT_FACEKIT:-}/FaceXModel" ]; then
        echo "${0##*/}: ICT_FACEKIT=${ICT_FACEKIT:-} holds no FaceXModel" >&2
        exit 1
    fi
}

# need_peers VENV REQUIREMENTS: the peers, and the program that stands beside them.
need_peers() {
    local venv=$1 wanted=$2
    if ! cmp -s "$wanted" "$venv/requirements.txt"; then
        echo "Installing the peers in $venv" >&2
        rm -rf "$venv"
        python3 -m venv "$venv"
        "$venv/bin/pip" install --quiet --requirement "$wanted"
        cp "$wanted" "$venv/requirements.txt"
    fi
    cargo build --quiet --release --locked --features fit --bin phiz-fit
}

#!/bin/sh
# Installs r3gw and the versions of constraints.txt into /opt/r3gw/.venv, on a bare Debian 12 as root.
# Both recipes beside this file run it, with the checkout in /opt/r3gw. PIP_ARGS may name an index
# that has torch for CPUs alone; the one on PyPI brings several GB of CUDA.
set -eu
cd /opt/r3gw
export DEBIAN_FRONTEND=noninteractive
apt-get update
apt-get install --yes --no-install-recommends python3.11-venv libgomp1 libatomic1 rsync
apt-mark manual libgomp1 libatomic1 rsync
apt-get install --yes --no-install-recommends g++ python3.11-dev
python3.11 -m venv .venv
pip="/opt/r3gw/.venv/bin/pip install --no-cache-dir --disable-pip-version-check ${PIP_ARGS:-}"
# torch first: the extension runs with the very version that it was built with.
$pip --constraint constraints.txt torch setuptools ninja numpy
# Kernels for all processors, not for the one that builds (r3gw.native.levels).
$pip --constraint constraints.txt --no-build-isolation \
    '.[pipeline,benchmark,view,cluster]'
rm -rf build src
apt-get purge --yes --auto-remove g++ python3.11-dev
rm -rf /var/lib/apt/lists/*
.venv/bin/python -m r3gw --help > /dev/null

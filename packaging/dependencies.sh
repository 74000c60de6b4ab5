#!/usr/bin/env bash
# Build GSL and FFTW as static libraries for wheels, and install Eigen, on machines that lack them: manylinux containers,
# and macOS, whose packages support its newest version only.
set -euo pipefail

fetch() { # ADDRESS SHA256: unpacked in the working directory
  curl --fail --silent --show-error --location --retry 3 --output archive.tar.gz "$1"
  if command -v sha256sum > /dev/null; then
    echo "$2  archive.tar.gz" | sha256sum --check --quiet
  else
    echo "$2  archive.tar.gz" | shasum --algorithm 256 --check --quiet
  fi
  tar xzf archive.tar.gz
}

sudo=$([ "$(id -u)" = 0 ] || echo sudo)
cd "$(mktemp -d)"

fetch https://ftp.gnu.org/gnu/gsl/gsl-2.8.tar.gz \
  6a99eeed15632c6354895b1dd542ed5a855c0f15d9ad1326c6fe2b2c9e423190
(
  cd gsl-2.8
  ./configure --quiet --disable-shared --with-pic --prefix=/usr/local
  make --silent -j2
  $sudo make --silent install
)

fetch https://www.fftw.org/fftw-3.3.10.tar.gz \
  56c932549852cddcfafdab3820b0200c7742675be92179e59e6215b340e26467
(
  cd fftw-3.3.10
  # In double and single precision; the instruction set is selected at run time.
  case $(uname -m) in
    x86_64) wide="--enable-sse2 --enable-avx --enable-avx2" ;;
    *) wide="" ;;
  esac
  for precision in "" --enable-single; do
    # shellcheck disable=SC2086
    ./configure --quiet --disable-shared --with-pic --disable-fortran --prefix=/usr/local $wide $precision
    make --silent -j2
    $sudo make --silent install
    make --silent clean
  done
)

fetch https://gitlab.com/libeigen/eigen/-/archive/3.4.0/eigen-3.4.0.tar.gz \
  8586084f71f9bde545ee7fa6d00288b264a2b7ac3607b974e54d13e7162c1c72
cmake -S eigen-3.4.0 -B eigen-build -DBUILD_TESTING=OFF -DEIGEN_BUILD_DOC=OFF > /dev/null
$sudo cmake --install eigen-build > /dev/null

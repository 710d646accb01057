# What a user types. Every target installs what it needs (apt, with sudo where needed) and builds what it uses.
#   make demo    a map, a signature and two flights without GNSS, in under 10 minutes; pictures in demo/
#   make test    builds and runs the tests, in under 15 minutes
#   make bench   compares with GDAL, gdal2tiles and OpenCV; writes bench.json
#   make real    the runs on real imagery of docs/real-imagery.md (LANDFIX_DATA names the folder)
#   make asan, make tsan   the tests under AddressSanitizer + UndefinedBehaviorSanitizer, or ThreadSanitizer
#   make aarch64 cross-builds the runtime and the kernels for 64-bit ARM (Debian) and runs their tests under qemu-user
#   make fuzz    ten minutes of fuzzing of the reader, and one of the nodes of navigability
#   make evaluation  how well images register with maps of other dates: the tables of docs/evaluation.md
#   make landmarks   how well landmarks and roads are found: the tables of docs/landmarks.md
#   make evaluate-navigability   how well maps foretell where they will serve: the tables of docs/evaluation.md
#   make routes  predicted errors and suggested routes against simulated flights: the table of docs/routes.md
#   make calibrate   draws the samples of tools/calibrate anew and fits probabilities and gates to them
#   make navigability  draws the samples of tools/navigability anew and fits the chance of a fix to them
#   make memory  builds of a 4-gigapixel image, and of 556 Mpx with landmarks and roads: peak memory and time
SHELL := /bin/bash
JOBS ?= $(shell nproc)
SECONDS_OF_FUZZING ?= 600
export LANDFIX_DATA ?= $(abspath ../shared/data)

.PHONY: evaluation landmarks evaluate-navigability routes calibrate navigability all setup release demo test bench real asan tsan aarch64 fuzz memory clean

all: release

setup:
	@tools/setup/install.sh

build/%/build.ninja: setup
	cmake --preset $*

release: build/release/build.ninja
	cmake --build --preset release -j $(JOBS)

demo: build/release/build.ninja
	cmake --build --preset release -j $(JOBS) --target landfix
	tools/demo.sh build/release/tools/landfix/landfix demo

test: release
	ctest --preset release -j $(JOBS)

bench: release
	build/release/tools/bench/landfix_bench --output bench.json

real: release
	tools/real_imagery.sh build/release/tools/landfix/landfix "$(LANDFIX_DATA)" build/real

evaluation: release
	tools/evaluation.sh build/release/tools/landfix/landfix "$(LANDFIX_DATA)" build/evaluation

landmarks: release
	tools/landmarks/evaluate.sh build/release/tools/landfix/landfix build/landmarks

evaluate-navigability: release
	tools/navigability/evaluate.sh build/release/tools/landfix/landfix "$(LANDFIX_DATA)" build/navigability

routes: release
	tools/route/evaluate.sh build/release/tools/landfix/landfix "$(LANDFIX_DATA)" build/routes

calibrate: release
	tools/setup/install.sh python3-numpy
	tools/calibrate/samples.sh build/release/tools/landfix/landfix tools/calibrate 101 5 "$(LANDFIX_DATA)"
	/usr/bin/python3 tools/calibrate/fit.py tools/calibrate/*.csv.gz >build/calibration_table.h
	mv build/calibration_table.h runtime/nav/calibration_table.h

navigability: release
	tools/setup/install.sh python3-numpy
	tools/navigability/samples.sh build/release/tools/navigability/landfix_navigability_samples tools/navigability
	/usr/bin/python3 tools/navigability/fit.py tools/navigability/drawn.csv.gz >build/model_table.h
	mv build/model_table.h builder/navigability/model_table.h

memory: release
	tools/bench/memory.sh build/release/tools/landfix/landfix

asan tsan: %: build/%/build.ninja
	cmake --build --preset $* -j $(JOBS)
	ctest --preset $* -j $(JOBS)

aarch64:
	tools/setup/install.sh g++-aarch64-linux-gnu qemu-user
	tools/setup/sysroot.sh arm64 build/aarch64-sysroot libc6-dev libflatbuffers-dev libfmt-dev libgeographiclib-dev \
	  libgtest-dev libproj-dev libsodium-dev libturbojpeg0-dev libzstd-dev nlohmann-json3-dev
	cmake --preset aarch64
	cmake --build --preset aarch64 -j $(JOBS)
	ctest --preset aarch64 -j $(JOBS)

fuzz:
	tools/setup/install.sh clang 'libclang-rt-14-dev|libclang-rt-dev'
	cmake --preset fuzz
	cmake --build --preset fuzz -j $(JOBS) --target fuzz_pack fuzz_navigability
	mkdir -p build/fuzz/found build/fuzz/found_navigability
	build/fuzz/tests/pack/fuzz/fuzz_pack -max_total_time=$(SECONDS_OF_FUZZING) -artifact_prefix=build/fuzz/found/ \
	  build/fuzz/found tests/pack/fuzz/corpus
	build/fuzz/tests/tiles/fuzz/fuzz_navigability -max_total_time=60 -artifact_prefix=build/fuzz/found_navigability/ \
	  build/fuzz/found_navigability tests/tiles/fuzz/corpus

clean:
	rm -rf build demo bench.json

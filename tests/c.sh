#!/usr/bin/env bash
# Checks the C library: its header, errors, inputs and governor, and that its example renders what the program renders,
# bit for bit, with the dynamic and with the static library, under the Khronos validation layer. It needs a C and a C++
# compiler, the layer (Debian's vulkan-validationlayers), Python 3 with `venv`, and what pip installs. PROFILE=dev
# builds slower libraries sooner. Where cbindgen is installed, the header is compared with the source.
set -euo pipefail
cd "$(dirname "$0")/.."

profile=${PROFILE:-release}
target=${CARGO_TARGET_DIR:-target}/$([ "$profile" = dev ] && echo debug || echo "$profile")
# Together, so that both have the same dependencies.
cargo build --profile "$profile" --quiet -p afterimage-cli -p afterimage-c
program=$(realpath "$target/afterimage")
libraries=$(realpath "$target")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-$folder}" PIP_DISABLE_PIP_VERSION_CHECK=1 LD_LIBRARY_PATH=$libraries

if command -v cbindgen > /dev/null; then
    (cd graph/c && cbindgen --quiet --verify --output include/afterimage.h)
else
    echo "cbindgen is not installed: the header is not compared with the source"
fi
flags=(-std=c99 -Wall -Wextra -Wpedantic -Werror -Igraph/c/include)
for source in examples/render.c tests/errors.c tests/governor.c tests/inputs.c; do
    name=$(basename "$source" .c)
    cc "${flags[@]}" "graph/c/$source" -o "$folder/$name" -L"$libraries" -lafterimage_c
    cc "${flags[@]}" "graph/c/$source" -o "$folder/$name-static" "$libraries/libafterimage_c.a" -lgcc_s -lutil -lrt \
        -lpthread -lm -ldl
done
echo '#include "afterimage.h"' | ${CXX:-c++} -std=c++11 -Wall -Wextra -Werror -Igraph/c/include -fsyntax-only -xc++ -

cat > "$folder/vk_layer_settings.txt" << END
khronos_validation.debug_action = VK_DBG_LAYER_ACTION_LOG_MSG
khronos_validation.report_flags = error,warn,info
khronos_validation.log_filename = $folder/layer.txt
khronos_validation.enables = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT
END

# Runs a program under the layer, which must say that it is there, and find nothing.
validated() {
    rm -f "$folder/layer.txt"
    VK_INSTANCE_LAYERS=VK_LAYER_KHRONOS_validation VK_LAYER_SETTINGS_PATH=$folder "$@"
    grep -q 'Khronos Validation Layer Active' "$folder/layer.txt"
    if grep -A 3 '(ERROR\|(WARN' "$folder/layer.txt" >&2; then return 1; fi
}
for test in governor governor-static; do "$folder/$test"; done
for test in errors inputs; do
    validated "$folder/$test"
    validated "$folder/$test-static"
done

"${PYTHON:-python3}" -m venv "$folder/python"
"$folder/python/bin/pip" install --quiet numpy OpenEXR pypng
cd "$folder"
"$program" pipelines tsushima --write tsushima.ron > /dev/null
echo 'Pipeline(extends: "tsushima.ron", outputs: { "light": "lit" })' > lit.ron
python/bin/python - << 'END'
import numpy, OpenEXR
y, x = numpy.mgrid[0:54, 0:96]
colors = [numpy.exp2(x / 8 - 6), 0.7 + y / 40, 0.4 + x * y / 5000]
pixels = numpy.stack([*colors, numpy.ones((54, 96))], axis=-1).astype(numpy.float16)
pixels[20:22, 30:32, :3] = 900
pixels.tofile("scene.f16")
channels = {name: numpy.ascontiguousarray(pixels[..., at]) for at, name in enumerate("RGBA")}
OpenEXR.File({"type": OpenEXR.scanlineimage}, channels).write("scene.exr")
END
"$program" render lit.ron scene.exr --plan bake=still --set lit.strength=0.02 --output light=light.exr --output display=display.png
for example in "$folder/render" "$folder/render-static"; do
    for output in light display; do
        validated "$example" lit.ron $output 96 54 lit.strength=0.02 < scene.f16 > $output
    done
    python/bin/python - << 'END'
import numpy, OpenEXR, png
with OpenEXR.File("light.exr", separate_channels=True) as file:
    light = numpy.stack([file.channels()[name].pixels for name in "RGBA"], axis=-1)
with open("display.png", "rb") as file:
    codes = numpy.vstack([numpy.uint8(row) for row in png.Reader(file=file).read()[2]])
for name, program in ("light", light), ("display", codes):
    ours = numpy.fromfile(name, program.dtype)
    assert ours.tobytes() == program.tobytes(), f"{name}: {numpy.count_nonzero(ours != program.ravel())} numbers differ"
    assert len(numpy.unique(ours)) > 200
    print(f"{name}: {ours.size} numbers of {ours.dtype} are equal")
END
done

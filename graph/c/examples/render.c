/* Renders an image in memory through a pipeline:
 *
 *     render PIPELINE OUTPUT WIDTH HEIGHT [NODE.PARAMETER=VALUE...] < in.f16 > out
 *
 * The input has four half floats for each pixel, linear Rec.709. What comes out are the numbers of an output of the
 * pipeline: codes for a display, or the floats of light. tests/c.sh builds and runs it. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "afterimage.h"

static const size_t SIZES[] = {0, 1, 2, 2, 4}; /* bytes of a number, by its type */

static int failed(const char *what) {
    fprintf(stderr, "%s: %s\n", what, afterimage_error());
    return 1;
}

static int render(AfterimagePipeline *look, const char *name, uint32_t width, uint32_t height, void *light) {
    AfterimageImage scene = {"scene", light, width, height, 4, AFTERIMAGE_F16, 0};
    AfterimageFrame frame = {.images = &scene, .image_count = 1};
    AfterimageImage output;
    float exposure[4];
    if (!afterimage_render(look, &frame) || !afterimage_output(look, name, &output)) {
        return failed("the frame");
    }
    size_t count = (size_t)output.width * output.height * output.channels;
    fwrite(output.numbers, SIZES[output.number_type], count, stdout);
    fprintf(stderr, "%s: %ux%ux%u\n", output.name, output.width, output.height, output.channels);
    if (afterimage_value(look, "metered", exposure)) {
        fprintf(stderr, "exposure: %.9g stops\n", exposure[0]);
    }
    return 0;
}

int main(int count, char **words) {
    if (count < 5) {
        fprintf(stderr, "usage: render PIPELINE OUTPUT WIDTH HEIGHT [NODE.PARAMETER=VALUE...]\n");
        return 2;
    }
    uint32_t width = (uint32_t)atoi(words[3]), height = (uint32_t)atoi(words[4]);
    void *light = calloc((size_t)width * height, 8);
    if (!light || fread(light, 8, (size_t)width * height, stdin) != (size_t)width * height) {
        fprintf(stderr, "the input is no %ux%u image\n", width, height);
        return 2;
    }
    AfterimagePipeline *look = afterimage_open(words[1]);
    int status = look ? 0 : failed(words[1]);
    for (int i = 5; status == 0 && i < count; i++) {
        char *value = strchr(words[i], '=');
        if (value) {
            *value++ = 0;
        }
        if (!afterimage_set(look, words[i], value)) {
            status = failed(words[i]);
        }
    }
    if (status == 0) {
        status = render(look, words[2], width, height, light);
    }
    afterimage_free(look);
    free(light);
    return status;
}

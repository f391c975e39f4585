/* Depth, cameras, volumes and times, by what they mean. tests/c.sh builds and runs it. */
#include <math.h>

#include "expect.h"

/* The distance of the depth 0.25 where the near plane, at 1, is `near` meters away and the far plane infinitely far. */
static void cameras(void) {
    AfterimagePipeline *look = afterimage_open(
        "Pipeline(inputs: { \"depth\": Depth, \"camera\": Camera }, outputs: { \"far\": \"far\" },"
        " nodes: { \"far\": LinearDepth(depth: \"depth\", camera: \"camera\", format: R32Float) })");
    float numbers[4 * 2];
    AfterimageImage depth = {"depth", numbers, 4, 2, 1, AFTERIMAGE_F32, 0}, far;
    AfterimageCamera camera = {.name = "camera"};
    AfterimageFrame frame = {.images = &depth, .image_count = 1};
    for (int i = 0; i < 8; i++) {
        numbers[i] = 0.25f;
    }
    for (int i = 0; i < 16; i++) {
        camera.view[i] = i % 5 == 0;
    }
    camera.projection[0] = camera.projection[5] = 1, camera.projection[11] = -1;
    FAILS(afterimage_render(look, &frame), "needs a camera for its input `camera`");
    frame.camera_count = 1;
    FAILS(afterimage_render(look, &frame), "`cameras` is a null pointer");
    frame.cameras = &camera;
    FAILS(afterimage_render(look, &frame), "the camera `camera`");
    for (float near = 1; near <= 2; near++) {
        camera.projection[14] = near;
        memcpy(camera.previous_view, camera.view, sizeof camera.view);
        memcpy(camera.previous_projection, camera.projection, sizeof camera.projection);
        HOLDS(afterimage_render(look, &frame) && afterimage_output(look, "far", &far));
        HOLDS(far.number_type == AFTERIMAGE_F32 && far.slices == 0);
        HOLDS(fabsf(((const float *)far.numbers)[0] - 4 * near) < 1e-5f);
    }
    camera.name = NULL;
    FAILS(afterimage_render(look, &frame), "`name` is a null pointer");
    camera.name = "depth";
    FAILS(afterimage_render(look, &frame), "");
    afterimage_free(look);
}

/* A meter of fog gives one of red light and takes an eighth of what is behind it. Its froxels end at 1, 2, 3, 4 m. */
static void volumes(void) {
    AfterimagePipeline *look = afterimage_open(
        "Pipeline(inputs: { \"scene\": Color, \"depth\": Depth, \"fog\": Color(volume: true) },"
        " outputs: { \"foggy\": \"foggy\" }, nodes: { \"foggy\": VolumetricComposite(source: \"scene\","
        " depth: \"depth\", volume: \"fog\", slices: Linear, near: 0.0, far: 4.0, format: Rgba32Float) })");
    const float meters[4] = {0.5f, 1, 2.75f, 1000};
    float light[4][4], fog[4][3 * 2][4];
    for (int x = 0; x < 4; x++) {
        light[x][0] = 16, light[x][1] = light[x][2] = 4, light[x][3] = 1;
    }
    for (int froxel = 0; froxel < 4 * 6; froxel++) {
        float far = froxel / 6 + 1, *numbers = fog[froxel / 6][froxel % 6];
        numbers[0] = far, numbers[1] = numbers[2] = 0, numbers[3] = 1 - far / 8;
    }
    AfterimageImage images[] = {{"scene", light, 4, 1, 4, AFTERIMAGE_F32, 0},
                                {"depth", meters, 4, 1, 1, AFTERIMAGE_F32, 0},
                                {"fog", fog, 3, 2, 4, AFTERIMAGE_F32, 4}}, foggy;
    AfterimageFrame frame = {.images = images, .image_count = 3};
    HOLDS(afterimage_render(look, &frame) && afterimage_output(look, NULL, &foggy));
    HOLDS(foggy.width == 4 && foggy.height == 1 && foggy.channels == 4 && foggy.number_type == AFTERIMAGE_F32);
    for (int x = 0; x < 4; x++) {
        const float *found = (const float *)foggy.numbers + 4 * x;
        float far = meters[x] < 4 ? meters[x] : 4, passed = 1 - far / 8;
        HOLDS(fabsf(found[0] - (16 * passed + far)) < 0.02f && fabsf(found[1] - 4 * passed) < 0.005f);
    }
    images[2].slices = 0;
    FAILS(afterimage_render(look, &frame), "fog");
    images[2].slices = 0xffffffff;
    FAILS(afterimage_render(look, &frame), "");
    afterimage_free(look);
}

/* A float has sixteen moments in a second after a week: of four frames it would make two. */
static void times(void) {
    AfterimagePipeline *look = afterimage_open(
        "Pipeline(inputs: { \"scene\": Color }, outputs: { \"hot\": \"hot\" }, nodes: {"
        " \"hot\": HeatHaze(source: \"scene\", strength: 0.1, scale: 0.3, format: Rgba32Float) })");
    float light[8][16][4], before[8][16][4];
    for (int i = 0; i < 8 * 16; i++) {
        float *texel = light[i / 16][i % 16];
        texel[0] = i / 16, texel[1] = i % 16, texel[2] = texel[3] = 1;
    }
    AfterimageImage scene = {"scene", light, 16, 8, 4, AFTERIMAGE_F32, 0}, hot;
    AfterimageFrame frame = {.images = &scene, .image_count = 1};
    for (int i = 0; i < 4; i++) {
        frame.time = 604800 + i / 60.0;
        HOLDS(afterimage_render(look, &frame) && afterimage_output(look, NULL, &hot));
        HOLDS(hot.width == 16 && hot.height == 8 && hot.channels == 4 && hot.number_type == AFTERIMAGE_F32);
        HOLDS(i == 0 || memcmp(hot.numbers, before, sizeof before) != 0);
        memcpy(before, hot.numbers, sizeof before);
    }
    afterimage_free(look);
}

int main(void) {
    cameras();
    volumes();
    times();
    return faults != 0;
}

/* What the functions do with null pointers, wrong names and wrong images. tests/c.sh builds and runs it. */
#include "expect.h"

static void nulls(void) {
    AfterimageFrame frame = {0};
    AfterimageImage image;
    float value[4];
    HOLDS(strcmp(afterimage_error(), "") == 0);
    FAILS(afterimage_open(NULL), "`source` is a null pointer");
    FAILS(afterimage_set(NULL, "a.b", "1"), "`pipeline` is a null pointer");
    FAILS(afterimage_set_tier(NULL, "low"), "`pipeline`");
    FAILS(afterimage_set_flag(NULL, "emissive", true), "`pipeline`");
    FAILS(afterimage_set_number(NULL, "lux", 1.0), "`pipeline`");
    FAILS(afterimage_set_type(NULL, AFTERIMAGE_F32), "`pipeline`");
    FAILS(afterimage_render(NULL, &frame), "`pipeline`");
    FAILS(afterimage_output(NULL, NULL, &image), "`pipeline`");
    FAILS(afterimage_value(NULL, "metered", value), "`pipeline`");
    afterimage_free(NULL);
}

static void names(AfterimagePipeline *look) {
    AfterimageImage image;
    float value[4];
    FAILS(afterimage_open("tsushma"), "there is no pipeline `tsushma`");
    FAILS(afterimage_open("\xff"), "`source` is not text in UTF-8");
    FAILS(afterimage_open("Pipeline(inputs: {"), "<text>:1:");
    FAILS(afterimage_set(look, NULL, "1"), "`name` is a null pointer");
    FAILS(afterimage_set(look, "lit.strength", NULL), "`value` is a null pointer");
    FAILS(afterimage_set(look, "lit.strenth", "1"), "strength");
    FAILS(afterimage_set(look, "lit.strength", "-1"), "lit.strength");
    FAILS(afterimage_set_tier(look, "lov"), "low");
    FAILS(afterimage_set_flag(look, "emisive", true), "emissive");
    FAILS(afterimage_set_number(look, NULL, 1.0), "`name`");
    FAILS(afterimage_set_type(look, 5), "no type of numbers is 5");
    FAILS(afterimage_output(look, NULL, NULL), "`image` is a null pointer");
    FAILS(afterimage_output(look, NULL, &image), "no frame");
    FAILS(afterimage_value(look, "meterd", value), "metered");
    FAILS(afterimage_value(look, "metered", value), "has no value `metered`");
    FAILS(afterimage_value(look, "metered", NULL), "`numbers` is a null pointer");
}

static void images(AfterimagePipeline *look) {
    float light[4 * 4 * 4] = {0};
    AfterimageImage scene = {"scene", light, 4, 4, 4, AFTERIMAGE_F32, 0}, image;
    AfterimageFrame frame = {.images = &scene, .image_count = 1};
    float value[4];
    for (int i = 0; i < 64; i++) {
        light[i] = 0.5f;
    }
    FAILS(afterimage_render(look, NULL), "`frame` is a null pointer");
    frame.image_count = 0;
    FAILS(afterimage_render(look, &frame), "needs an image for its input `scene`");
    frame.images = NULL, frame.image_count = 1;
    FAILS(afterimage_render(look, &frame), "`images` is a null pointer");
    frame.images = &scene;
    scene.channels = 3;
    FAILS(afterimage_render(look, &frame), "3 channels");
    scene.channels = 4, scene.number_type = AFTERIMAGE_U8;
    FAILS(afterimage_render(look, &frame), "the type 1");
    scene.number_type = AFTERIMAGE_F32, scene.width = 0;
    FAILS(afterimage_render(look, &frame), "has no pixels");
    scene.width = 0xffffffff, scene.height = 0xffffffff;
    FAILS(afterimage_render(look, &frame), "larger than the memory");
    scene.width = scene.height = 4, scene.name = "seen";
    FAILS(afterimage_render(look, &frame), "no input `seen`");
    scene.name = NULL;
    FAILS(afterimage_render(look, &frame), "`name` is a null pointer");
    scene.name = "scene", scene.numbers = NULL;
    FAILS(afterimage_render(look, &frame), "`numbers` is a null pointer");
    scene.numbers = light;
    HOLDS(afterimage_render(look, &frame));
    HOLDS(afterimage_output(look, NULL, &image) && image.width == 4 && image.height == 4);
    HOLDS(image.channels == 3 && image.number_type == AFTERIMAGE_U8 && strcmp(image.name, "display") == 0);
    HOLDS(afterimage_value(look, "metered", value) && value[3] == 1.0f);
    FAILS(afterimage_output(look, "light", &image), "no frame with such an output");
    frame.continues = 1, frame.dt = 1.0f / 24.0f, frame.number = 1;
    HOLDS(afterimage_set_tier(look, "low") && afterimage_set_type(look, AFTERIMAGE_F32));
    HOLDS(afterimage_set_flag(look, "emissive", false) && afterimage_render(look, &frame));
    HOLDS(afterimage_output(look, "display", &image) && image.number_type == AFTERIMAGE_F32 && image.channels == 4);
    HOLDS(afterimage_set_tier(look, NULL) && afterimage_set_type(look, 0));
}

int main(void) {
    nulls();
    AfterimagePipeline *look = afterimage_open("tsushima");
    HOLDS(look != NULL);
    names(look);
    images(look);
    afterimage_free(look);
    return faults != 0;
}

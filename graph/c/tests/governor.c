/* The tiers that a governor may choose, and its reasons. It needs no device. tests/c.sh builds and runs it. */
#include <math.h>

#include "expect.h"

static const char *const PIPELINE =
    "Pipeline(\n"
    "    inputs: { \"scene\": Color },\n"
    "    nodes: { \"lit\": Exposure(source: \"scene\", stops: 0.0) },\n"
    "    outputs: { \"light\": \"lit\" },\n"
    "    tiers: { \"low\": { \"lit.stops\": 1.0 }, \"high\": { \"lit.stops\": 2.0 }, \"best\": { \"lit.stops\": 3.0 } },\n"
    "    claims: {\n"
    "        \"low\": Claim(ms: 1.0, jod: 8.0, for: \"desk\", on: \"nothing\"),\n"
    "        \"high\": Claim(ms: 2.0, jod: 9.5, for: \"desk\", on: \"nothing\"),\n"
    "        \"best\": Claim(ms: 3.0, jod: 9.9, for: \"phone\", on: \"nothing\"),\n"
    "    },\n"
    ")\n";
static const char *const TIERS[] = {"low", "high", "best"};

static bool has_tier(AfterimagePipeline *look, const char *name) {
    const char *tier;
    return afterimage_tier(look, &tier) && tier && strcmp(tier, name) == 0;
}

/* Four seconds of frames that all take so many milliseconds. */
static void frames(AfterimagePipeline *look, double ms) {
    for (int frame = 0; frame < 400; frame++) HOLDS(afterimage_report_frame_time(look, ms, 0.01));
}

int main(void) {
    AfterimagePipeline *look = afterimage_open(PIPELINE);
    AfterimageLimits limits = {.ms = 4.0, .min_jod = 9.0, .display = "desk"}, free = {.ms = 4.0};
    const char *text = "";
    HOLDS(look && afterimage_tier(look, &text) && !text);
    HOLDS(afterimage_govern(look, &free, TIERS, 3) && has_tier(look, "low"));
    /* The claim of `best` is for a phone, and that of `low` too small. */
    HOLDS(afterimage_govern(look, &limits, TIERS, 3) && has_tier(look, "high"));
    HOLDS(afterimage_shortfall(look, &text) && !text);
    frames(look, 1.0);
    HOLDS(has_tier(look, "high"));
    frames(look, 20.0);
    HOLDS(has_tier(look, "high") && afterimage_shortfall(look, &text) && text);
    HOLDS(text && strstr(text, "over 4.00, and no cheaper tier claims 9.00 JOD"));
    limits.display = NULL;
    HOLDS(afterimage_govern(look, &limits, TIERS, 3) && has_tier(look, "high"));
    frames(look, 1.0);
    HOLDS(has_tier(look, "best"));
    limits.min_jod = NAN;
    HOLDS(afterimage_govern(look, &limits, TIERS, 3) && has_tier(look, "best"));
    HOLDS(afterimage_shortfall(look, &text) && text && strstr(text, "the budget of 4.00 ms is not held"));
    HOLDS(afterimage_govern(look, NULL, NULL, 0) && has_tier(look, "best"));
    HOLDS(afterimage_shortfall(look, &text) && !text);
    FAILS(afterimage_govern(look, &limits, TIERS, 0), "tier");
    FAILS(afterimage_govern(look, &limits, NULL, 3), "`tiers` is a null pointer");
    FAILS(afterimage_govern(NULL, &limits, TIERS, 3), "`pipeline` is a null pointer");
    FAILS(afterimage_tier(look, NULL), "`tier` is a null pointer");
    FAILS(afterimage_shortfall(look, NULL), "`shortfall` is a null pointer");
    FAILS(afterimage_report_frame_time(NULL, 1.0, 0.01), "`pipeline` is a null pointer");
    const char *unknown[] = {"lov"};
    FAILS(afterimage_govern(look, &limits, unknown, 1), "low");
    HOLDS(has_tier(look, "best"));
    afterimage_free(look);
    return faults > 0;
}

// Hardly a pixel has light below 0, so generated code tries several pixels without what such light needs. Where the
// least number that was noted is below 0, it makes them again.
var<private> light_is_tried: bool;
var<private> light_lowest: f32;

fn note_light(lowest: f32) {
    light_lowest = min(light_lowest, lowest);
}

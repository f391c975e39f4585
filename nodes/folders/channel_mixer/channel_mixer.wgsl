import afterimage::grade::bounded_scene;

struct ChannelMixer { red: vec3f, green: vec3f, blue: vec3f }

fn channel_mixer(source: vec4f, params: ChannelMixer) -> vec4f {
    let mixed = vec3f(dot(params.red, source.rgb), dot(params.green, source.rgb), dot(params.blue, source.rgb));
    return vec4f(bounded_scene(mixed), source.a);
}

"""Lets ffprobe and PyAV, a decoder of its own, judge the films that `render` reads and writes: codes, color tags, frame
times, sound, standard input and output, and the error without ffmpeg: films.py PROGRAM FOLDER"""

import os
import subprocess

import av
import numpy

from judge import check, pipeline, run, start

SIZE, COUNT = (320, 180), 24
PIPELINE = """Pipeline(inputs: { "in": DisplayLinear }, nodes: { "out": Encode(source: "in", transfer: %s, primaries: %s) },
    outputs: { "display": "out", "light": "in" })"""
WEIGHTS = {"bt709": (0.2126, 0.0722), "bt2020nc": (0.2627, 0.0593)}


def source(name, pixels, primaries, transfer, matrix, codec, sound=True, times=None):
    tags = ["-color_primaries", primaries, "-color_trc", transfer, "-colorspace", matrix, "-color_range", "tv"]
    params = f"setparams=range=tv:color_primaries={primaries}:color_trc={transfer}:colorspace={matrix}"
    # The pictures are made in RGB, and get the matrix of the film.
    out = {"bt709": "bt709", "bt2020nc": "bt2020"}[matrix]
    times = f",setpts='{times}'" if times else ""
    # Of HDR: colors within Rec.709, below 1000 cd/m2, as the pipeline has its light.
    within = "" if primaries == "bt709" else "lutrgb=r=128+val/16:g=128+val/16:b=128+val/16,"
    chain = f"format=gbrp,{within}scale=out_color_matrix={out}:out_range=tv:flags=accurate_rnd,format={pixels},{params}{times}"
    words = ["ffmpeg", "-v", "error", "-y", "-f", "lavfi", "-i", f"testsrc2=s={SIZE[0]}x{SIZE[1]}:r=24000/1001"]
    words += ["-f", "lavfi", "-i", "sine=440:r=48000"] if sound else []
    words += ["-frames:v", str(COUNT), "-t", "1.1", "-vf", chain, "-fps_mode", "passthrough", *tags, *codec]
    run(*words, *(["-c:a", "pcm_s16le"] if sound else []), name)


def probe(name):
    entries = "stream=codec_name,profile,pix_fmt,color_range,color_space,color_transfer,color_primaries,r_frame_rate,nb_read_frames"
    text = run("ffprobe", "-v", "error", "-count_frames", "-select_streams", "v:0", "-show_entries", entries, "-of", "default=nw=1", name)
    return dict(line.split("=", 1) for line in text.decode().split() if "=" in line)


def times(name):
    text = run("ffprobe", "-v", "error", "-select_streams", "v:0", "-show_entries", "packet=pts_time", "-of", "csv=p=0", name)
    return sorted(float(word.strip(",")) for word in text.decode().split())


def time_codes(name):
    entries = "stream_tags=timecode,TIMECODE:format_tags=timecode,TIMECODE"
    words = ["ffprobe", "-v", "error", "-select_streams", "v:0", "-show_entries", entries, "-of", "default=nw=1:nk=1", name]
    return set(run(*words).decode().split())


def sound(name):
    return run("ffmpeg", "-v", "error", "-i", name, "-map", "0:a", "-c", "copy", "-f", "md5", "-")


def heard(name):
    """The samples of the sound, decoded."""
    return numpy.frombuffer(run("ffmpeg", "-v", "error", "-i", name, "-map", "0:a", "-ac", "1", "-f", "f32le", "-"), "<f4")


def frames(name):
    """Signals of all frames: red, green, blue from 0 to 1."""
    found = []
    with av.open(name) as film:
        for frame in film.decode(video=0):
            samples = frame.format.name
            if samples == "gbrp16le":
                planes = [numpy.frombuffer(p, "<u2").reshape(frame.height, -1)[:, :frame.width] for p in frame.planes]
                green, blue, red = (plane / 65535 for plane in planes)
            else:
                bits = 12 if "12" in samples else 10
                planes = [numpy.frombuffer(p, "<u2").reshape(-1, p.line_size // 2)[:, :p.width] / 2.0 ** (bits - 8) for p in frame.planes[:3]]
                y, cb, cr = (numpy.repeat(numpy.repeat(p, frame.height // p.shape[0], 0), frame.width // p.shape[1], 1) for p in planes)
                kr, kb = WEIGHTS["bt2020nc" if frame.colorspace == 9 else "bt709"]
                y, cb, cr = (y - 16) / 219, (cb - 128) / 224, (cr - 128) / 224
                red, blue = y + 2 * (1 - kr) * cr, y + 2 * (1 - kb) * cb
                green = (y - kr * red - kb * blue) / (1 - kr - kb)
            found.append(numpy.stack([red, green, blue], -1))
    return numpy.array(found)


def main(program):
    pipeline("sdr.ron", PIPELINE % ("Gamma, gamma: 2.4", "Rec709"))
    pipeline("pq.ron", PIPELINE % ("Pq", "Rec2020"))
    pipeline("hlg.ron", PIPELINE % ("Hlg", "Rec2020"))
    lossless = ["-c:v", "ffv1"]
    source("sdr.mkv", "yuv444p10le", "bt709", "bt709", "bt709", lossless)
    source("twelve.mkv", "yuv444p12le", "bt709", "bt709", "bt709", lossless)
    source("pq.mkv", "yuv444p10le", "bt2020", "smpte2084", "bt2020nc", lossless)
    source("hlg.mkv", "yuv444p10le", "bt2020", "arib-std-b67", "bt2020nc", lossless)
    source("sdr.mov", "yuv422p10le", "bt709", "bt709", "bt709", ["-c:v", "prores_ks", "-profile:v", "hq", "-timecode", "01:00:59:20"])
    # Frames of 1, 2 and 3 steps.
    source("times.mov", "yuv422p10le", "bt709", "bt709", "bt709", ["-c:v", "prores_ks", "-video_track_timescale", "24000", "-enc_time_base", "1/24000"],
           times="1001*(N+mod(N\\,3)*(mod(N\\,3)-1)/2)/24000/TB")

    tags = {"sdr": ("bt709", "bt709", "bt709"), "pq": ("bt2020", "smpte2084", "bt2020nc"), "hlg": ("bt2020", "arib-std-b67", "bt2020nc")}
    for kind, (primaries, transfer, matrix) in tags.items():
        exact = frames(f"{kind}.mkv").clip(0, 1)
        for out, video, codec, pixels, limit in [
            (f"{kind}-out.mkv", None, "ffv1", "gbrp16le", 0.1), (f"{kind}-4444.mov", "prores4444", "prores", "yuv444p1", 3.0),
            (f"{kind}-out.mov", None, "prores", "yuv422p10le", None), (f"{kind}-264.mp4", "h264", "h264", "yuv420p10le", None),
            (f"{kind}-265.mp4", "hevc -preset ultrafast", "hevc", "yuv420p10le", None),
        ]:
            given = f"{kind}.mkv"
            words = [program, "render", f"{kind}.ron", given, "-o", out] + (["--video", video] if video else [])
            said = subprocess.run(words, check=True, capture_output=True, text=True).stderr
            found = probe(out)
            stated = tuple(found.get(f"color_{what}") for what in ("primaries", "transfer", "space"))
            matrix_of = "gbr" if pixels.startswith("gbr") else matrix
            check(f"{out}: codec {codec} {found['pix_fmt']}", found["codec_name"] == codec and found["pix_fmt"].startswith(pixels))
            check(f"{out}: tags {stated}", stated == (primaries, transfer, matrix_of))
            check(f"{out}: {found['nb_read_frames']} frames", found["nb_read_frames"] == str(COUNT))
            same = numpy.allclose(times(out), times(given), atol=1e-3 if out.endswith("mkv") else 2e-3)
            check(f"{out}: times", same)
            if out.endswith("mov"):
                check(f"{out}: sound", sound(out) == sound(given))
            if out.endswith("mp4"):
                theirs, ours = heard(given), heard(out)
                is_same = abs(len(theirs) - len(ours)) < 2048 and abs(theirs.std() / ours.std() - 1) < 0.02
                check(f"{out}: sound as AAC, with a note", is_same and "encoded as AAC" in said)
            if limit:
                errors = numpy.abs(frames(out).clip(0, 1) - exact)
                mean, worst = errors.mean() * 1023, errors.max() * 1023
                check(f"{out}: signals within {worst:.2f} codes of 10 bits, {mean:.3f} on average", mean < limit)
    # One generation of ProRes more.
    luma = numpy.abs(luma_codes("sdr-out.mov") - luma_codes("sdr.mov")).mean()
    check(f"sdr-out.mov: mean luma {luma:.3f} codes of 10 bits of another generation", luma < 1.0)

    run(program, "render", "sdr.ron", "times.mov", "-o", "times-out.mov")
    check("frame times of 1, 2 and 3 steps", numpy.allclose(times("times-out.mov"), times("times.mov"), atol=1e-6) and len(set(numpy.diff(times("times.mov")).round(4))) > 1)
    run(program, "render", "sdr.ron", "sdr.mov", "-o", "part.mov", "--frames", "7-12")
    part, whole = frames("part.mov"), frames("sdr.mov")
    check("a range of frames is that range", len(part) == 6 and numpy.abs(part - whole[6:12]).mean() < 0.01 and abs(times("part.mov")[0]) < 1e-6)
    check("the time code of a range is that of its first frame", time_codes("part.mov") == {"01:01:00:02"})
    for name in ["whole.mov", "whole.mp4", "whole.mkv"]:
        run(program, "render", "sdr.ron", "sdr.mov", "-o", name)
        run(program, "render", "sdr.ron", name, "-o", "second.mov", "--frames", "2-3")
        found = time_codes(name), time_codes("second.mov")
        check(f"{name}: time codes {found}", found == ({"01:00:59:20"}, {"01:00:59:21"}))
    run(program, "render", "sdr.ron", "sdr.mkv", "-o", "frame.##.png", "--depth", "16", "--frames", "3-5")
    run(program, "render", "sdr.ron", "frame.##.png", "-o", "back.mov", "--fps", "23.976")
    check("numbered images at 23.976", probe("back.mov")["r_frame_rate"] == "24000/1001" and len(times("back.mov")) == 3)
    noted = subprocess.run([program, "render", "sdr.ron", "twelve.mkv", "-o", "ten.mov"], capture_output=True, text=True, check=True).stderr
    check("bits that are lost are told", "has 12 bits" in noted and "10 of prores" in noted)

    png = open("frame.04.png", "rb").read()
    run(program, "render", "sdr.ron", "frame.04.png", "-o", "file.png", "--depth", "16")
    piped = run(program, "render", "sdr.ron", "-", "-o", "-", "--depth", "16", input=png)
    check("standard input and output: PNG", piped == open("file.png", "rb").read())
    exr = run(program, "render", "sdr.ron", "-", "-o", "-", "--output", "light", input=png)
    check("standard output: EXR", exr[:4] == b"\x76\x2f\x31\x01")

    for words in [["sdr.mov", "-o", "a.png"], ["frame.##.png", "-o", "a.mov"]]:
        without = subprocess.run([program, "render", "sdr.ron", *words], capture_output=True, text=True, env=os.environ | {"PATH": "/nowhere"})
        check(f"without ffmpeg: {without.stderr.strip()}", without.returncode == 2 and "there is none on the PATH" in without.stderr)
    before = sorted(os.listdir())
    broken = subprocess.run([program, "render", "sdr.ron", "sdr.mov", "-o", "a.mov", "--video", "prores -no_such_option"], capture_output=True, text=True)
    check(f"an option that ffmpeg refuses: {broken.stderr.strip().splitlines()[-1]}", broken.returncode == 1 and sorted(os.listdir()) == before)
    with open("sdr.mov", "rb") as file:
        open("cut.mov", "wb").write(file.read()[:-90000])
    cut = subprocess.run([program, "render", "sdr.ron", "cut.mov", "-o", "a.mov"], capture_output=True, text=True)
    check(f"a film without its end: {cut.stderr.strip()}", cut.returncode == 1 and not os.path.exists("a.mov"))


def luma_codes(name):
    with av.open(name) as film:
        planes = [numpy.frombuffer(frame.planes[0], "<u2").reshape(frame.height, -1)[:, :frame.width] for frame in film.decode(video=0)]
    return numpy.array(planes).astype("float64")


start(main)

"""What screenshots of the viewer's page show; the status is 1 if it is not what the task says.

seen.py same PROGRAM.png SHOT.png PAGE.png  the picture in the middle of a bare page is the program's; stores it as PAGE.png
seen.py errors SHOT.png                     errors are written
seen.py picture SHOT.png                    the upper half, below the bar, has a picture with light and shadow
"""

import sys

from PIL import Image, ImageStat

# The color in which the viewer writes errors.
ERROR = (0xF0, 0x6A, 0x5C)


def same(program, shot, page):
    program = Image.open(program).convert("RGB")
    shot = Image.open(shot).convert("RGB")
    left, top = ((whole - part) // 2 for whole, part in zip(shot.size, program.size))
    picture = shot.crop((left, top, left + program.width, top + program.height))
    picture.save(page)
    low, high = zip(*program.getextrema())
    differences = [abs(a - b) for a, b in zip(program.tobytes(), picture.tobytes())]
    within = sum(difference <= 1 for difference in differences) / len(differences)
    print(f"  within 1 code: {100 * within:.3f} %, at most {max(differences)}")
    return max(high) - min(low) > 100 and within >= 0.999 and max(differences) <= 4


def errors(shot):
    data = Image.open(shot).convert("RGB").tobytes()
    pixels = zip(data[::3], data[1::3], data[2::3])
    red = sum(all(abs(a - b) <= 30 for a, b in zip(pixel, ERROR)) for pixel in pixels)
    print(f"  {red} pixels of errors")
    return red > 40


def picture(shot):
    shot = Image.open(shot).convert("RGB")
    part = shot.crop((shot.width // 20, 100, shot.width * 19 // 20, 100 + shot.height // 4))
    spread = max(ImageStat.Stat(part).stddev)
    print(f"  deviation {spread:.0f}")
    return spread > 20


task, *files = sys.argv[1:]
sys.exit(not {"same": same, "errors": errors, "picture": picture}[task](*files))

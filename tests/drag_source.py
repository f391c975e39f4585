"""Drags files onto a place of a window of X11: tests/drag_source.py WINDOW X Y FILE...

X and Y are pixels of the window. As the desktops do, it holds the pointer during the drag, so that the window learns the
place from the messages of the drag, and from what the server sends after it. Ends with 0 once the window has taken the
files. Needs python-xlib: pip install python-xlib
"""

import sys
import time
from pathlib import Path

from Xlib import X, display
from Xlib.protocol import event

VERSION = 5
SECONDS = 20


def main() -> None:
    number, x, y = (int(text) for text in sys.argv[1:4])
    uris = "".join(f"{Path(name).resolve().as_uri()}\r\n" for name in sys.argv[4:]).encode()
    server = display.Display()
    root, atom = server.screen().root, server.intern_atom
    window = server.create_resource_object("window", number)
    source = root.create_window(0, 0, 1, 1, 0, X.CopyFromParent, override_redirect=1)
    source.map()
    source.set_selection_owner(atom("XdndSelection"), X.CurrentTime)
    server.sync()
    mode, nothing = X.GrabModeAsync, X.NONE
    held = source.grab_pointer(False, X.PointerMotionMask, mode, mode, nothing, nothing, X.CurrentTime)
    if held != X.GrabSuccess:
        sys.exit("another program holds the pointer")
    place = root.translate_coords(window, x, y)
    root.warp_pointer(place.x, place.y)

    def send(name: str, *numbers: int) -> None:
        data = [source.id, *numbers, 0, 0, 0, 0][:5]
        window.send_event(event.ClientMessage(window=window, client_type=atom(name), data=(32, data)))
        server.flush()

    send("XdndEnter", VERSION << 24, atom("text/uri-list"))
    send("XdndPosition", 0, place.x << 16 | place.y, X.CurrentTime, atom("XdndActionCopy"))
    end = time.monotonic() + SECONDS
    while time.monotonic() < end:
        if not server.pending_events():
            time.sleep(0.01)
            continue
        answer = server.next_event()
        if answer.type == X.SelectionRequest:
            answer.requestor.change_property(answer.property, answer.target, 8, uris)
            fields = ("time", "requestor", "selection", "target", "property")
            answer.requestor.send_event(event.SelectionNotify(**{name: getattr(answer, name) for name in fields}))
            server.flush()
        elif answer.type == X.ClientMessage and answer.client_type == atom("XdndStatus"):
            if not answer.data[1][1] & 1:
                sys.exit("the window takes no files")
            # The button is let go: the drop is sent, and the pointer is free.
            time.sleep(0.3)
            send("XdndDrop", 0, X.CurrentTime)
            server.ungrab_pointer(X.CurrentTime)
            server.flush()
        elif answer.type == X.ClientMessage and answer.client_type == atom("XdndFinished"):
            return
    sys.exit("the window never says that it has taken the files")


main()

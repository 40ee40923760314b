"""What a page does at its websocket, for tests that are one."""

import json

from starlette.websockets import WebSocketDisconnect

from drillrig_env.room.app import ROOM as _PATH

HERE = "http://127.0.0.1:8347"


ROOM = f"ws://127.0.0.1:8347{_PATH}"


class Page:
    """What a page does at its websocket."""

    def __init__(self, socket, setting=None, version=1):
        self.socket = socket
        self.welcome = self.text("welcome")
        self.say("begin", version=version, setting=setting or {})

    def say(self, do, **entries):
        self.socket.send_text(json.dumps({"do": do, **entries}))

    def next(self):
        message = self.socket.receive()
        if message["type"] == "websocket.close":
            raise WebSocketDisconnect(message["code"], message.get("reason"))
        return message["text"] if message.get("text") is not None else message["bytes"]

    def text(self, kind, **wanted):
        """The next text of a kind whose entries are as wanted."""
        while True:
            message = self.next()
            if isinstance(message, str):
                found = json.loads(message)
                if found["is"] == kind and all(found[name] == value for name, value in wanted.items()):
                    return found

    def frame(self):
        while True:
            message = self.next()
            if isinstance(message, bytes):
                return message


def sent_away(page):
    """The code with which a page is sent away."""
    while True:
        message = page.socket.receive()
        if message["type"] == "websocket.close":
            return message["code"]

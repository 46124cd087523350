"""A run's page on this computer alone: http://127.0.0.1, finished or still in training."""

import webbrowser
from collections.abc import Callable
from functools import partial
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from r3gw.files import InputError
from r3gw.training.watched import CURVES, PICTURE, ask
from r3gw.view.page import TEMPLATES
from r3gw.view.runs import Run

ADDRESS = "127.0.0.1"
Content = tuple[str, bytes]  # media type, body


class Pages:
    """What the server answers, by path; the trained page is made once and kept."""

    def __init__(self, run: Run, make: Callable[[Run], str]) -> None:
        """Show ``run``; ``make`` writes its page when it is trained."""
        self.run, self.make = run, make
        self._page: bytes | None = None

    def answer(self, path: str) -> Content | None:
        """The content of a path; None if there is none."""
        match path.split("?")[0]:
            case "/" if self.run.is_trained:
                return "text/html; charset=utf-8", self._trained()
            case "/":
                return "text/html; charset=utf-8", (TEMPLATES / "watch.html").read_bytes()
            case "/progress.json":
                return "application/json", self._progress()
            case "/progress.png":
                return _file(self.run.folder / PICTURE, "image/png")
            case _:
                return None

    def _trained(self) -> bytes:
        if self._page is None:
            self._page = self.make(self.run).encode()
        return self._page

    def _progress(self) -> bytes:
        """The curves so far; the training learns that it is watched."""
        if self.run.is_trained:
            return b'{"done": true}'
        ask(self.run.folder)
        found = _file(self.run.folder / CURVES, "application/json")
        return b"{}" if found is None else found[1]


def _file(path: Path, kind: str) -> Content | None:
    try:
        return kind, path.read_bytes()
    except FileNotFoundError:
        return None


class Handler(BaseHTTPRequestHandler):
    """Answers GET requests that are addressed to this computer by name."""

    def __init__(self, pages: Pages, *rest: object) -> None:
        self.pages = pages
        super().__init__(*rest)  # type: ignore[arg-type]

    def do_GET(self) -> None:
        """Answer from `Pages`."""
        # A page elsewhere could name this server by a host name of its own (DNS rebinding).
        host = (self.headers.get("Host") or "").rsplit(":", 1)[0]
        if host not in (ADDRESS, "localhost"):
            self.send_error(403, "this server answers to 127.0.0.1 alone")
            return
        try:
            content = self.pages.answer(self.path)
        except InputError as error:
            self.send_error(500, "the page cannot be made", str(error))
            return
        if content is None:
            self.send_error(404)
            return
        kind, body = content
        self.send_response(200)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_: object) -> None:
        """Say nothing per request."""


def server_of(run: Run, make: Callable[[Run], str], port: int) -> ThreadingHTTPServer:
    """A server that listens on this computer alone; ``port`` 0 takes any free one.

    Raises:
        InputError: If the port is taken.
    """
    try:
        return ThreadingHTTPServer((ADDRESS, port), partial(Handler, Pages(run, make)))
    except OSError as error:
        raise InputError(
            f"port {port} of {ADDRESS} cannot be used ({error.strerror}); give another --port"
        ) from error


def serve(
    run: Run, make: Callable[[Run], str], port: int, say: Callable[[str], None], *, browse: bool
) -> None:
    """Serve a run's page until the keyboard interrupts.

    Raises:
        InputError: If the port is taken.
    """
    server = server_of(run, make, port)
    address = f"http://{ADDRESS}:{server.server_port}/"
    say(f"{run.folder} at {address} (Ctrl+C ends)")
    if browse:
        webbrowser.open(address)
    try:
        server.serve_forever()
    except KeyboardInterrupt:
        say("ended")
    finally:
        server.server_close()

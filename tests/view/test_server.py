"""The server of `r3gw view`: this computer alone, and a training that knows it is watched."""

import json
from contextlib import contextmanager
from http.client import HTTPConnection
from threading import Thread

import pytest

from r3gw.files import InputError
from r3gw.training.watched import ASKED, CURVES, PICTURE
from r3gw.view.runs import Run
from r3gw.view.server import server_of


@contextmanager
def served(run: Run):
    """Run a server; yields a function that gets a path's status and body."""
    made = []

    def make(found: Run) -> str:
        made.append(found)
        return "<p>the page</p>"

    server = server_of(run, make, 0)
    thread = Thread(target=server.serve_forever)
    thread.start()

    def get(path: str, host: str | None = None) -> tuple[int, bytes]:
        connection = HTTPConnection("127.0.0.1", server.server_port, timeout=10)
        headers = {} if host is None else {"Host": host}
        connection.request("GET", path, headers=headers)
        answer = connection.getresponse()
        body = answer.read()
        connection.close()
        return answer.status, body

    try:
        yield get, made
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


@pytest.fixture
def run(tmp_path) -> Run:
    """A run without a model yet."""
    return Run(tmp_path, tmp_path / "model.safetensors", tmp_path)


def test_a_trained_run_shows_its_page_which_is_made_once(run):
    run.model.touch()
    with served(run) as (get, made):
        assert get("/") == get("/?again") == (200, b"<p>the page</p>")
        assert json.loads(get("/progress.json")[1]) == {"done": True}
    assert made == [run]


def test_a_run_in_training_is_watched(run):
    with served(run) as (get, made):
        assert b"training in progress" in get("/")[1]
        assert get("/progress.json") == (200, b"{}")
        assert (run.folder / ASKED).exists()
        assert get("/progress.png")[0] == 404
        (run.folder / CURVES).write_text('{"iteration": 7}')
        (run.folder / PICTURE).write_bytes(b"png")
        assert json.loads(get("/progress.json")[1])["iteration"] == 7
        assert get("/progress.png") == (200, b"png")
    assert made == []


@pytest.mark.parametrize(
    "path",
    ["/model.safetensors", "/../run.json", "/%2e%2e/run.json", "/etc/passwd"],
)
def test_nothing_else_is_served(run, path):
    (run.folder / "model.safetensors").touch()
    with served(run) as (get, _):
        assert get(path)[0] == 404


@pytest.mark.parametrize("host", ["elsewhere.example", "elsewhere.example:8040"])
def test_other_names_of_this_computer_are_refused(run, host):
    with served(run) as (get, _):
        assert get("/", host)[0] == 403
        assert get("/", "localhost:1")[0] == 200


def test_it_listens_on_this_computer_alone_and_says_when_a_port_is_taken(run):
    server = server_of(run, lambda _: "", 0)
    try:
        assert server.server_address[0] == "127.0.0.1"
        with pytest.raises(InputError, match="give another --port"):
            server_of(run, lambda _: "", server.server_port)
    finally:
        server.server_close()

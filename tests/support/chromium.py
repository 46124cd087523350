"""Chromium without a window and without a GPU, driven by a script in the page itself.

The page is served with a script appended that runs jobs and posts their results back, so no
browser driver is needed.
"""

import json
import shutil
import subprocess
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from queue import Queue
from threading import Thread
from typing import Any

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--no-first-run",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--hide-scrollbars",
)
DRIVER = """
<script>
const post = (path, value) => fetch(path, { method: "POST", body: JSON.stringify(value) });
for (const kind of ["error", "unhandledrejection"]) {
  addEventListener(kind, (event) => post("/complaint", String(event.message ?? event.reason)));
}
for (const kind of ["error", "warn"]) {
  const own = console[kind];
  console[kind] = (...all) => { post("/complaint", all.map(String).join(" ")); own(...all); };
}
(async () => {
  while (!globalThis.r3gwApp) await new Promise((resolve) => setTimeout(resolve, 20));
  const jobs = await (await fetch("/jobs")).json();
  for (const job of jobs) {
    try {
      await post("/result", { value: await eval(`(async () => { ${job} })()`) });
    } catch (error) {
      await post("/result", { failure: String(error) });
    }
  }
})();
</script>
"""


def find_browser() -> str | None:
    """Path of a Chromium, if one is installed."""
    return next((path for name in NAMES if (path := shutil.which(name))), None)


@dataclass
class Session:
    """A page in a browser; jobs are bodies of async JavaScript functions."""

    html: str
    results: Queue = field(default_factory=Queue)
    complaints: list[str] = field(default_factory=list)
    jobs: list[str] = field(default_factory=list)
    files: dict[str, bytes] = field(default_factory=dict)

    def run(self, profile: Path, window: tuple[int, int] = (800, 600)) -> list[Any]:
        """Results of all jobs, in order."""
        with self._served() as port, _chromium(port, profile, window):
            found = [self.results.get(timeout=180) for _ in self.jobs]
        failures = [each["failure"] for each in found if "failure" in each]
        assert not failures, failures
        return [each.get("value") for each in found]

    @contextmanager
    def _served(self):
        session = self

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self):
                name = self.path.split("?")[0]
                body = {
                    "/": (session.html + DRIVER).encode(),
                    "/jobs": json.dumps(session.jobs).encode(),
                    **session.files,
                }.get(name)
                self.send_response(404 if body is None else 200)
                self.end_headers()
                self.wfile.write(body or b"")

            def do_POST(self):
                value = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
                if self.path == "/complaint":
                    session.complaints.append(value)
                else:
                    session.results.put(value)
                self.send_response(200)
                self.end_headers()

            def log_message(self, *_):
                pass

        server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        thread = Thread(target=server.serve_forever)
        thread.start()
        try:
            yield server.server_port
        finally:
            server.shutdown()
            server.server_close()
            thread.join()


@contextmanager
def _chromium(port: int, profile: Path, window: tuple[int, int]):
    command = [
        find_browser(),
        *FLAGS,
        f"--user-data-dir={profile}",
        f"--window-size={window[0]},{window[1]}",
        f"http://127.0.0.1:{port}/",
    ]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield
    finally:
        process.terminate()
        process.wait(timeout=30)

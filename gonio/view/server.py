"""The server behind `gonio view`: one page, a handful of answers, and nothing that another page could ask.

It listens on 127.0.0.1 alone. A request has to name that host (a foreign name that points here does not
do), come from the page itself, and carry the token that stands in the fragment of the page's address, which
browsers do not send. Routes are the keys of a dictionary; no path of a request ever names a file.
"""

from __future__ import annotations

import functools
import json
import secrets
import socket
import threading
import time
import webbrowser
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from concurrent.futures import TimeoutError as Late
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, ClassVar
from urllib.parse import quote

from gonio.export.targets import TARGETS
from gonio.export.text import export
from gonio.export.tree import ExportError
from gonio.fields import ModelError
from gonio.files import stamps
from gonio.foreign import ForeignError
from gonio.foreign.model import ForeignModel
from gonio.materials import Material, MaterialError
from gonio.view import page
from gonio.view.page import Names
from gonio.view.scene import shapes

HOST = "127.0.0.1"
BODY_MAX = 16384  # bytes of a question
WORK_TIME_MAX = 20.0  # seconds for one answer
POLL = 0.4  # seconds between two looks at the user's files

POLICY = (
    "default-src 'self'; img-src 'self' data: blob:; object-src 'none'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'"
)


class Refused(Exception):  # noqa: N818 (a word for the page, not an error of the program)
    """An answer other than 200, with its one sentence."""

    def __init__(self, status: int, reason: str, **more: Any) -> None:
        """The HTTP status, what to say, and what else the page should know."""
        super().__init__(reason)
        self.status = status
        self.more = more


class Viewer(ThreadingHTTPServer):
    """The server. `url` is what to open."""

    daemon_threads = True
    address_family = socket.AF_INET

    def __init__(
        self, texts: Iterable[str], files: Iterable[str] | Names = (), port: int = 0
    ) -> None:
        """Texts of models to open with, files that the page may show; port 0 takes a free one."""
        self.texts = list(texts)
        self.names = files if isinstance(files, Names) else Names(files)
        self.token = secrets.token_urlsafe(24)
        self.workers = ThreadPoolExecutor(2, thread_name_prefix="gonio-view")
        self.closing = threading.Event()
        super().__init__((HOST, port), Handler)

    @property
    def origin(self) -> str:
        """Of the page, as browsers write it."""
        return f"http://{HOST}:{self.server_port}"

    @property
    def url(self) -> str:
        """The page with its token, and the models to show."""
        shown = "".join(
            f"&{side}={quote(text, safe=':,=/.', errors='surrogateescape')}"
            for side, text in zip("ab", self.texts, strict=False)
        )
        return f"{self.origin}/#token={self.token}{shown}"

    def server_close(self) -> None:
        """Stop, and let open streams end."""
        self.closing.set()
        self.workers.shutdown(wait=False, cancel_futures=True)
        super().server_close()

    # --- answers ---------------------------------------------------------------------------------------

    def start(self, body: Mapping[str, Any]) -> Any:
        """What the page knows when it opens."""
        return page.start(self.names, self.texts)

    def model(self, body: Mapping[str, Any]) -> Any:
        """A model with its shaders."""
        return page.payload(self.names, _text(body, "text"))

    def options(self, body: Mapping[str, Any]) -> Any:
        """A model's options with what is refused and why, and what is unused."""
        return page.choices(self.names, _text(body, "text"))

    def albedo(self, body: Mapping[str, Any]) -> Any:
        """A directional albedo."""
        wo = body.get("wo")
        if not isinstance(wo, list) or not all(isinstance(v, (int, float)) for v in wo):
            raise Refused(400, "the question has no 'wo'.")
        return {"albedo": page.albedo(self.names, _text(body, "text"), wo)}

    def code(self, body: Mapping[str, Any]) -> Any:
        """What `gonio export` writes."""
        return {"text": code(self.names, _text(body, "text"), _text(body, "language"))}


def code(names: Names, text: str, language: str) -> str:
    """The text that `gonio export` writes for a model, byte for byte.

    Raises:
        Refused: a language that is none.
    """
    from gonio.export import materialx
    from gonio.export.files import texts

    if language not in (*TARGETS, materialx.NAME):
        raise Refused(400, f"no language {language!r}.")
    what = names.find(text)
    if isinstance(what, ForeignModel):
        raise Refused(422, f"{what.foreign.name} stays in its own language; nothing is exported.")
    model = what.model if isinstance(what, Material) else what
    name = "".join(c if c.isalnum() else "_" for c in what.name)
    if language == materialx.NAME:
        return "\n".join(map(str, texts({name: model}, [language]).values()))
    return export({name: model}, language)[0].source


def _text(body: Mapping[str, Any], key: str) -> str:
    value = body.get(key)
    if not isinstance(value, str):
        raise Refused(400, f"the question has no {key!r}.")
    return value


class Handler(BaseHTTPRequestHandler):
    """One request."""

    server: Viewer
    protocol_version = "HTTP/1.1"
    server_version = "gonio"
    sys_version = ""
    timeout = 30
    error_message_format = "%(code)d %(message)s\n"
    error_content_type = "text/plain"

    # The routes; nothing else exists.
    PAGES: ClassVar[dict[str, tuple[str, Callable[[], str]]]] = {
        "/": (
            "text/html",
            lambda: page.document("gonio view", '<script type="module" src="/viewer.js"></script>'),
        )
    } | {
        f"/{name}": (kind, functools.partial(page.file, name)) for name, kind in page.FILES.items()
    }
    ANSWERS: ClassVar[dict[str, Callable[[Viewer, Mapping[str, Any]], Any]]] = {
        "/api/start": Viewer.start,
        "/api/model": Viewer.model,
        "/api/options": Viewer.options,
        "/api/albedo": Viewer.albedo,
        "/api/code": Viewer.code,
    }

    def do_GET(self) -> None:
        """The page and its script."""
        self._answer(self._page)

    def do_POST(self) -> None:
        """A question of the page."""
        self._answer(self._question)

    def _answer(self, make: Callable[[], None]) -> None:
        try:
            try:
                self._check_host()
                make()
            except Refused as refused:
                self._refuse(refused)
        except (BrokenPipeError, ConnectionResetError):  # the page has gone
            self.close_connection = True

    def _page(self) -> None:
        name = self.path.partition("?")[0]
        if name not in self.PAGES:
            raise Refused(404, "there is no such page.")
        kind, make = self.PAGES[name]
        self._send(200, make().encode(), f"{kind}; charset=utf-8")

    def _question(self) -> None:
        self._check_page()
        body = self._body()
        if self.path == "/api/changes":
            self._stream()
            return
        if self.path not in self.ANSWERS:
            raise Refused(404, "there is no such answer.")
        answer = self._work(self.ANSWERS[self.path], body)
        # In ASCII, for names of files need not be Unicode
        text = json.dumps(answer, allow_nan=False, separators=(",", ":"))
        self._send(200, text.encode(), "application/json")

    def _work(self, make: Callable[[Viewer, Mapping[str, Any]], Any], body: Any) -> Any:
        """An answer, in time."""
        try:
            return self.server.workers.submit(make, self.server, body).result(WORK_TIME_MAX)
        except Late:
            raise Refused(
                503, f"this took longer than {WORK_TIME_MAX:.0f} s and was given up."
            ) from None
        except (ModelError, ExportError, MaterialError, ForeignError, OSError) as error:
            raise Refused(422, str(error).partition("\n")[0]) from None
        except Refused:
            raise
        except Exception as error:  # a user's own model can raise anything
            raise Refused(500, f"{type(error).__name__}: {error}") from None

    # --- what is refused -------------------------------------------------------------------------------

    def _check_host(self) -> None:
        if self.headers.get_all("Host") != [f"{HOST}:{self.server.server_port}"]:
            raise Refused(403, "this is not the host that was asked for.")

    def _check_page(self) -> None:
        if self.headers.get("Origin") != self.server.origin:
            raise Refused(403, "only the page itself may ask.")
        token = self.headers.get("X-Gonio-Token", "")
        if not secrets.compare_digest(token.encode(), self.server.token.encode()):
            raise Refused(
                403, "the address has no valid token; use the one that gonio view printed."
            )
        if self.headers.get_content_type() != "application/json":
            raise Refused(415, "questions are JSON.")

    def _body(self) -> Mapping[str, Any]:
        length = self.headers.get("Content-Length", "")
        # A body in chunks has another length than the one that stands here
        if not length.isdecimal() or "Transfer-Encoding" in self.headers:
            raise Refused(411, "the question has no length.")
        if int(length) > BODY_MAX:
            raise Refused(413, f"a question has at most {BODY_MAX} bytes.")
        try:
            body = json.loads(self.rfile.read(int(length)))
        except (ValueError, RecursionError):
            raise Refused(400, "the question is not JSON.") from None
        if not isinstance(body, dict):
            raise Refused(400, "the question is not a JSON object.")
        return body

    # --- sending ---------------------------------------------------------------------------------------

    def _head(self, status: int, kind: str) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Security-Policy", POLICY)
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("Referrer-Policy", "no-referrer")
        self.send_header("Cross-Origin-Resource-Policy", "same-origin")
        self.send_header("Cross-Origin-Opener-Policy", "same-origin")
        self.send_header("Cache-Control", "no-store")

    def _send(self, status: int, content: bytes, kind: str) -> None:
        self._head(status, kind)
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)

    def _refuse(self, refused: Refused) -> None:
        self.close_connection = True  # the rest of a refused question is not read
        text = json.dumps({"error": str(refused), **refused.more})
        self._send(refused.status, text.encode(), "application/json")

    def _stream(self) -> None:
        """Server-sent events: a line whenever one of the user's files has changed."""
        names = self.server.names
        seen = {name: stamps(names.paths(name)) for name in names.files}
        self._head(200, "text/event-stream")
        self.send_header("Connection", "close")
        self.end_headers()
        self.close_connection = True
        beat = time.monotonic()
        while not self.server.closing.wait(POLL):
            for name, before in list(seen.items()):
                now = stamps(names.paths(name))
                if now != before:
                    seen[name] = now
                    self.wfile.write(f"data: {json.dumps({'file': name})}\n\n".encode())
            if time.monotonic() - beat > 10:
                beat = time.monotonic()
                self.wfile.write(b": still here\n\n")
            self.wfile.flush()

    def log_message(self, format: str, *arguments: Any) -> None:
        """Say nothing: the page shows what went wrong."""


def serve(viewer: Viewer, *, open_browser: bool = True) -> None:
    """Answer until the user stops it."""
    viewer.workers.submit(shapes)  # while the browser starts
    if open_browser:
        webbrowser.open(viewer.url)
    try:
        viewer.serve_forever(poll_interval=0.2)
    finally:
        viewer.server_close()

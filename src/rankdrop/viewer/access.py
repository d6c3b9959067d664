"""Who may talk to the viewer: nobody from another origin, nobody from another machine without the token.

viser serves the page and the websocket on one port and asks nobody who they are. A page of any site could open that
websocket from the user's browser (websockets know no same-origin rule), or reach the page under its own name by DNS
rebinding. So every HTTP request and every websocket handshake first passes this gate:

- the Host has to be a name of this machine's loopback, unless the viewer is exposed;
- an Origin, where the browser sends one, has to be the page's own;
- exposed, the token has to come in the URL (?token=…) of the page, and then in the cookie that the page was given.

viser behind the gate: every request and handshake is asked before viser sees it, and the gate is tried at once.
"""

from __future__ import annotations

import contextlib
import errno
import functools
import gzip
import hmac
import io
import logging
import secrets
import socket
import threading
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from http import HTTPStatus
from http.client import HTTPConnection, HTTPException
from http.cookies import CookieError, SimpleCookie
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qs, urlsplit

from rankdrop.errors import MissingExtraError, OptionError, visible
from rankdrop.robot import LARGEST_FILE

if TYPE_CHECKING:
    import viser


LOOPBACK = ("127.0.0.1", "localhost", "[::1]")

LARGEST_MESSAGE = 2 * 2**20
"""Bytes of one message of a page; its uploads come in parts of half a megabyte."""
MOST_CLIENTS = 32
"""Pages that are connected at one time."""
LARGEST_UPLOAD = LARGEST_FILE
"""Bytes of a file that is uploaded, and of all that are under way at one time."""
_LAST_PORT = 65535
_LATER = 1013  # the websocket's code for "try again later"
_TRIES = 100  # ports after the default one
_starting = threading.Lock()

_LABELS = """<style>label, p:has(> label), .mantine-Notification-description { color: inherit !important; }
.mantine-Slider-markLabel { color: inherit !important; opacity: 0.8; }
[role=tab][aria-selected=true] span { color: #00598c !important; }
[data-mantine-color-scheme=dark] [role=tab][aria-selected=true] span { color: #74c0fc !important; }
[data-copy] { font: inherit; padding: 0.3em 0.8em; border: 0; border-radius: 2px; background: #495057; color: #fff;
  cursor: pointer; }
.mantine-Button-root:not([data-disabled]) .mantine-Button-label { color: #fff; }
.mantine-Button-root:not([data-disabled]) { background-color: #495057; }</style>
<script>
// viser's sliders, number boxes and small buttons have no names: they take the words next to them
function named() {
  for (const label of document.querySelectorAll("label[for]")) {
    let row = label.parentElement;
    while (row && !row.querySelector("[role=slider], input")) row = row.parentElement;
    for (const one of row ? row.querySelectorAll("[role=slider], input") : []) {
      if (!one.getAttribute("aria-label") && !one.labels?.length) one.setAttribute("aria-label", label.textContent);
    }
  }
  for (const one of document.querySelectorAll("button")) {
    if (one.textContent.trim() || one.getAttribute("aria-label")) continue;
    one.setAttribute("aria-label", one.closest(".mantine-Notification-root") ? "close the message" : "settings");
  }
}
new MutationObserver(named).observe(document, { childList: true, subtree: true });
// buttons that copy a text: the clipboard belongs to the page; where it has none, a field is selected and copied
document.addEventListener("click", async (event) => {
  const button = event.target.closest?.("[data-copy]");
  if (!button) return;
  try {
    await navigator.clipboard.writeText(button.dataset.copy);
  } catch {
    const field = document.body.appendChild(document.createElement("textarea"));
    field.value = button.dataset.copy;
    field.select();
    document.execCommand("copy");
    field.remove();
  }
  button.textContent = "copied";
});
</script>"""


@dataclass(frozen=True, slots=True)
class Gate:
    """The rules of one server.

    Attributes:
        port: it listens on.
        token: to be shown by everybody; None on the loopback address.
    """

    port: int
    token: str | None = None

    def refuses(self, path: str, headers: Mapping[str, str]) -> str | None:
        """Why a request or handshake is refused; None where it may pass.

        Args:
            path: of the request, with its query.
            headers: by name; names are looked up as "Host", "Origin", "Cookie".
        """
        host = headers.get("Host", "").lower()
        if self.token is None and host not in {f"{name}:{self.port}" for name in LOOPBACK}:
            return "this viewer answers on the loopback address only"
        origin = headers.get("Origin")
        if origin is not None and origin.lower() not in {f"http://{host}", f"https://{host}"}:
            return "requests from other pages are refused"
        if self.token is not None and not (self._in_query(path) or self._in_cookie(headers)):
            return "the token is missing: use the whole address that the viewer printed"
        return None

    def cookie(self, path: str) -> str | None:
        """The cookie to set with the answer to a request that showed the token."""
        if self.token is None or not self._in_query(path):
            return None
        return f"{self._name}={self.token}; HttpOnly; SameSite=Strict; Path=/"

    @property
    def _name(self) -> str:
        return f"rankdrop-{self.port}"  # cookies do not tell ports apart: the name has to

    def _in_query(self, path: str) -> bool:
        return any(self._is(word) for word in parse_qs(urlsplit(path).query).get("token", []))

    def _in_cookie(self, headers: Mapping[str, str]) -> bool:
        try:
            kept = SimpleCookie(headers.get("Cookie", ""))
        except CookieError:
            return False
        return self._name in kept and self._is(kept[self._name].value)

    def _is(self, word: str) -> bool:
        return self.token is not None and hmac.compare_digest(word.encode(), self.token.encode())


def new_token() -> str:
    """An unguessable word for a URL (128 bits)."""
    return secrets.token_urlsafe(16)


def free_port(host: str, port: int, *, next_one: bool) -> int:
    """A port that can be listened on.

    Args:
        host: address to listen on.
        port: the one wanted; 0 for any.
        next_one: take a later one where it is in use.

    Raises:
        OptionError: the address is not one of this machine, or the port is in use or not allowed.
    """
    if not 0 <= port <= _LAST_PORT:
        raise OptionError("there is no such port", where="--port", got=port, allowed=f"0 … {_LAST_PORT}")
    for candidate in range(port, min(port + (_TRIES if next_one else 1), _LAST_PORT + 1)):
        try:
            with socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET, socket.SOCK_STREAM) as probe:
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                probe.bind((host, candidate))
                return int(probe.getsockname()[1])
        except PermissionError:
            raise OptionError("no permission to listen on this port", where="--port", got=candidate,
                              mend="take one from 1024 up") from None  # fmt: skip
        except socket.gaierror:
            raise OptionError("this is no address of this machine", where="--host", got=host) from None
        except OSError as error:
            if error.errno != errno.EADDRINUSE:
                raise OptionError("cannot listen there", where="--host", got=f"{host}: {error.strerror}") from None
    raise OptionError("the port is in use", where="--port", got=port, mend="name another, or 0 for any that is free")


def start_gated(host: str, gate: Gate, arrived: Callable[[str], None] | None = None) -> viser.ViserServer:
    """A viser server that answers nobody whom the gate refuses.

    viser offers no hook before its own request handler. It passes that handler to `websockets.asyncio.server.serve`,
    which is wrapped while the server starts. Afterwards a request under a foreign name is tried: if it were answered
    (another viser, built differently), nothing is served.

    Args:
        host: address to listen on.
        gate: its rules.
        arrived: is told the path, with its query, of every request for the page that the gate lets in.

    Raises:
        MissingExtraError: viser is not installed.
        OptionError: the port has been taken meanwhile, or this viser cannot be gated.
    """
    try:
        import viser
        import websockets.asyncio.server as sockets
    except ImportError:
        raise MissingExtraError("viser", "viewer", "the viewer") from None
    with _starting, _guarding(sockets, gate, arrived), contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host=host, port=gate.port, label="rankdrop", verbose=False)
    closed: Any = server
    closed.request_share_url = lambda verbose=True: None  # a client could ask for a tunnel through viser's own server
    if server.get_port() != gate.port:
        stop(server)
        raise OptionError("the port is in use", where="--port", got=gate.port, mend="name another")
    if not _holds(host, gate.port):
        stop(server)
        raise OptionError(
            "this version of viser cannot be guarded against other pages, so it is not started", where="viewer",
            got=f"viser {viser.__version__}", mend="another version of viser, or tell us",
        )
    return server


def stop(server: viser.ViserServer) -> None:
    """End it; viser says so on stdout, where results belong."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


@contextlib.contextmanager
def _guarding(sockets: Any, gate: Gate, arrived: Callable[[str], None] | None) -> Iterator[None]:
    """Within it, websocket servers ask the gate first."""
    plain = sockets.serve

    @functools.wraps(plain)
    def serve(handler: Any, *args: Any, **options: Any) -> Any:
        inner = options.get("process_request")
        bounds = {"max_size": LARGEST_MESSAGE, "max_queue": 4, "process_request": _asking(gate, inner, arrived),
                  "logger": _page_logger()}  # fmt: skip
        return plain(_few(handler), *args, **{**options, **bounds})

    sockets.serve = serve
    try:
        yield
    finally:
        sockets.serve = plain


def _page_logger() -> logging.Logger:
    """A log of connections in which an error is one line: who sends junk does not fill the terminal with tracebacks."""
    log = logging.getLogger("rankdrop.viewer.pages")
    log.addFilter(_one_line)  # twice is once
    return log


def _one_line(record: logging.LogRecord) -> bool:
    if record.exc_info:
        error = record.exc_info[1]
    else:
        error = None
    if error is not None:
        reason = visible(" ".join(f"{type(error).__name__}: {error}".split()))[:200]
        record.msg, record.args = f"a connection is closed, it sent what cannot be read: {reason}", ()
        record.exc_info = record.exc_text = None
    return True


def _few(handler: Any) -> Any:
    """The handler of connections, for so many at one time; the next one is told to try again later."""
    connected = 0

    async def handle(connection: Any) -> None:
        nonlocal connected
        if connected >= MOST_CLIENTS:
            await connection.close(_LATER, f"{MOST_CLIENTS} pages are connected")
            return
        connected += 1
        try:
            await handler(connection)
        finally:
            connected -= 1

    return handle


class _Uploads(dict[str, Any]):
    """viser's uploads under way: one that says it is too large is not begun, and none gets longer than it said."""

    def __init__(self, say: Callable[[str], None]) -> None:
        super().__init__()
        self._say = say

    def __setitem__(self, key: str, state: Any) -> None:
        sizes = [message["total_bytes"] for message in (*self.values(), state)]
        parts = state["part_count"]
        if not all(isinstance(size, int) and size >= 0 for size in (*sizes, parts)) or len(sizes) > MOST_CLIENTS:
            return
        if sum(sizes) > LARGEST_UPLOAD or parts > max(1, state["total_bytes"]):
            self._say(f"the file is too large to be opened; allowed: at most {LARGEST_UPLOAD // 2**20} MB")
            return
        super().__setitem__(key, {**state, "parts": _UploadParts(state["total_bytes"])})


class _UploadParts(dict[int, bytes]):
    """The parts of one upload; what goes beyond its length is not kept, and the length then shows it."""

    def __init__(self, length: int) -> None:
        super().__init__()
        self._left = length

    def __setitem__(self, key: int, content: bytes) -> None:
        self._left -= len(content)
        super().__setitem__(key, content if self._left >= 0 else b"")


def bound_uploads(server: viser.ViserServer, say: Callable[[str], None]) -> None:
    """Let uploads take no more than `LARGEST_UPLOAD` at one time; `say` is told of one that is refused.

    Raises:
        OptionError: this viser keeps its uploads elsewhere.
    """
    gui: Any = server.gui
    if not isinstance(getattr(gui, "_current_file_upload_states", None), dict):
        import viser

        raise OptionError("uploads to this version of viser cannot be bounded, so it is not started", where="viewer",
                          got=f"viser {viser.__version__}", mend="another version of viser, or tell us")  # fmt: skip
    gui._current_file_upload_states = _Uploads(say)


def _asking(gate: Gate, inner: Any, arrived: Callable[[str], None] | None) -> Any:
    def process_request(connection: Any, request: Any) -> Any:
        try:
            reason = gate.refuses(request.path, request.headers)
        except Exception:  # two Host lines, say: websockets raises where a header is not single
            reason = "the request cannot be read"
        if reason is not None:
            return connection.respond(HTTPStatus.FORBIDDEN, f"rankdrop: {reason}\n")
        if inner is not None:
            response = inner(connection, request)
        else:
            response = None
        cookie = gate.cookie(request.path)
        if response is not None and arrived is not None and "Sec-WebSocket-Key" not in request.headers:
            with contextlib.suppress(Exception):  # a link that says nothing moves nothing; the page comes either way
                arrived(request.path)
        if response is not None:
            _label(response)
            _set_security_headers(response.headers, cookie)
        return response

    return process_request


def _label(response: Any) -> None:
    """Names for what the page of viser leaves without: screen readers and the keyboard need them."""
    if "text/html" not in response.headers.get("Content-Type", "") or response.status_code != HTTPStatus.OK:
        return
    packed = response.headers.get("Content-Encoding") == "gzip"
    if packed:
        page = gzip.decompress(response.body)
    else:
        page = bytes(response.body)
    page = page.replace(b"</head>", _LABELS.encode() + b"</head>", 1)
    if packed:
        response.body = gzip.compress(page, 1)
    else:
        response.body = page
    if "Content-Length" in response.headers:
        del response.headers["Content-Length"]
        response.headers["Content-Length"] = str(len(response.body))


def _set_security_headers(headers: Any, cookie: str | None) -> None:
    """No other page may frame this one, and nothing is loaded from elsewhere."""
    sources = "default-src 'self' data: blob: 'unsafe-inline' 'unsafe-eval'; connect-src 'self' ws: data: blob:; "
    headers.update({"X-Frame-Options": "DENY", "Referrer-Policy": "no-referrer", "Cache-Control": "no-store",
                    "Content-Security-Policy": f"{sources}frame-ancestors 'none'"})  # fmt: skip
    if cookie is not None:
        headers["Set-Cookie"] = cookie


def _holds(host: str, port: int) -> bool:
    """Whether a page request and a handshake under a foreign name and origin are refused."""
    address = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(host, host)
    handshake = {
        "Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13",
        "Sec-WebSocket-Key": "cmFua2Ryb3AgdGhlIGdhdA==",
    }  # fmt: skip
    for more in ({}, handshake):
        connection = HTTPConnection(address, port, timeout=10)
        try:
            connection.request("GET", "/", headers={"Host": "elsewhere.invalid", "Origin": "http://elsewhere.invalid",
                                                    **more})  # fmt: skip
            if connection.getresponse().status != HTTPStatus.FORBIDDEN:
                return False
        except (OSError, HTTPException):
            return False
        finally:
            connection.close()
    return True

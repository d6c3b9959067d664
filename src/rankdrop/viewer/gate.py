"""Who may talk to the viewer: nobody from another origin, nobody from another machine without the token.

viser serves the page and the websocket on one port and asks nobody who they are. A page of any site could open that
websocket from the user's browser (websockets know no same-origin rule), or reach the page under its own name by DNS
rebinding. So every HTTP request and every websocket handshake first passes this gate:

- the Host has to be a name of this machine's loopback, unless the viewer is exposed;
- an Origin, where the browser sends one, has to be the page's own;
- exposed, the token has to come in the URL (?token=…) of the page, and then in the cookie that the page was given.
"""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs, urlsplit

LOOPBACK = ("127.0.0.1", "localhost", "[::1]")


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
        if self.token is not None and not (self._shown(path) or self._kept(headers)):
            return "the token is missing: use the whole address that the viewer printed"
        return None

    def cookie(self, path: str) -> str | None:
        """The cookie to set with the answer to a request that showed the token."""
        if self.token is None or not self._shown(path):
            return None
        return f"{self._name}={self.token}; HttpOnly; SameSite=Strict; Path=/"

    @property
    def _name(self) -> str:
        return f"rankdrop-{self.port}"  # cookies do not tell ports apart: the name has to

    def _shown(self, path: str) -> bool:
        return any(self._is(word) for word in parse_qs(urlsplit(path).query).get("token", []))

    def _kept(self, headers: Mapping[str, str]) -> bool:
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

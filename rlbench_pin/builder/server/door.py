"""Who may come in: the head of a request is judged before anything behind the door sees it."""

from __future__ import annotations

import hmac
from collections.abc import Collection
from dataclasses import dataclass
from urllib.parse import urlsplit

LOCAL_NAMES = ("127.0.0.1", "localhost", "::1")
"""What the host may be called; other names are those of pages that want to be taken for this machine (DNS rebinding)."""


@dataclass(frozen=True)
class Refusal:
    """What is answered instead of the page."""

    status: str
    """Status line of HTTP without the version, such as `403 Forbidden`."""
    message: str
    """Why, and the next step."""
    location: str = ""
    """Where the browser shall go instead, for redirections."""

    def response(self) -> bytes:
        """Return the whole answer."""
        body = f"{self.message}\n".encode()
        lines = [f"HTTP/1.1 {self.status}", "Content-Type: text/plain; charset=utf-8", f"Content-Length: {len(body)}"]
        lines += [f"Location: {self.location}"] if self.location else []
        return "\r\n".join([*lines, "Connection: close", "Cache-Control: no-store", "", ""]).encode("latin-1") + body


@dataclass(frozen=True)
class Door:
    """The rules of one server."""

    token: str
    """What the address begins with."""
    names: Collection[str] = LOCAL_NAMES
    """What the host may be called."""

    def judge(self, head: bytes) -> bytes | Refusal:
        """Return the head of a request with the token taken out of its path, or why it is refused.

        Args:
            head: Request line and headers, up to and with the empty line.
        """
        lines = head.decode("latin-1").split("\r\n")
        method, _, rest = lines[0].partition(" ")
        target, _, version = rest.rpartition(" ")
        if not version.startswith("HTTP/1.") or not target.startswith("/"):
            return Refusal("400 Bad Request", "This is no request of a browser.")
        headers = _headers(lines[1:])
        if (refusal := self._judge_names(headers)) is not None:
            return refusal
        if method != "GET":
            return Refusal("405 Method Not Allowed", f"The builder answers GET alone, not {method[:20]}.")
        given, slash, path = target[1:].partition("/")
        given, question, _ = given.partition("?")
        if not hmac.compare_digest(given.encode("latin-1"), self.token.encode("latin-1")):
            return Refusal("403 Forbidden", "The address lacks its token. Open the whole address that the builder printed.")
        if not slash and not question and "upgrade" not in headers:
            return Refusal("307 Temporary Redirect", "The page is one slash further.", f"/{self.token}/")
        opened = target[1 + len(given) :] if slash else f"/{target[1 + len(given) :]}"
        return "\r\n".join([f"{method} {opened} {version}", *lines[1:]]).encode("latin-1")

    def _judge_names(self, headers: dict[str, list[str]]) -> Refusal | None:
        """Refuse hosts of other names, and requests that pages from elsewhere send."""
        hosts, origins = headers.get("host", []), headers.get("origin", [])
        if len(hosts) != 1 or _host_name(f"//{hosts[0]}") not in self.names:
            return Refusal("403 Forbidden", f"The builder answers to {', '.join(self.names)} alone, not to other names.")
        if len(origins) > 1 or any(_site(origin) != hosts[0].lower() for origin in origins):
            return Refusal(
                "403 Forbidden", "The request comes from a page of another site. Open the address in a tab of its own."
            )
        return None


def _site(origin: str) -> str:
    """Return host and port of an origin, in small letters; empty where it is none."""
    try:
        parts = urlsplit(origin)
    except ValueError:
        return ""
    return parts.netloc.lower() if parts.scheme in ("http", "https") else ""


def _host_name(address: str) -> str:
    try:
        return urlsplit(address).hostname or ""
    except ValueError:
        return ""


def _headers(lines: list[str]) -> dict[str, list[str]]:
    """Return the values of each header, by its name in small letters."""
    headers: dict[str, list[str]] = {}
    for line in lines:
        name, colon, value = line.partition(":")
        if colon:
            headers.setdefault(name.strip().lower(), []).append(value.strip())
    return headers

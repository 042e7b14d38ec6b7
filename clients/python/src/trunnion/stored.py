"""Stored documents and the tags that protect them from lost updates."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Generic, TypeVar

if TYPE_CHECKING:
    import httpx

Document = TypeVar("Document")


class Stored(Generic[Document]):
    """A document as it was read, with its `ETag`. Give it back to say which revision you mean."""

    def __init__(self, document: Document, etag: str) -> None:
        self.document = document
        self.etag = etag

    def __repr__(self) -> str:
        return f"<Stored {self.etag}: {self.document!r}>"


def stored(response: httpx.Response) -> Stored[Document]:
    """The document of an answer."""
    return Stored(response.json(), response.headers["etag"])


def to_put(document: Any, taken: type[Any]) -> dict[str, Any]:
    """The members of a document that a `PUT` of this type takes: an answer has its id, revision and time besides."""
    found = document.document if isinstance(document, Stored) else document
    members = taken.__required_keys__ | taken.__optional_keys__
    added = {"machine_id", "tool_id", "revision", "created_at"} - members
    return {name: value for name, value in found.items() if name not in added}


def if_match(condition: str | Stored[Document] | None) -> dict[str, str]:
    """The header that names the revision to replace."""
    if condition is None:
        return {}
    return {"If-Match": condition.etag if isinstance(condition, Stored) else condition}

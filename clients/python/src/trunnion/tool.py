"""The tool table of a machine, and the wear of its cutters."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, cast

from . import arrays
from .connection import CSV, SVG, Connection, new_idempotency_key, part
from .contract import ToolProfile
from .figure import Figure
from .stored import Stored, if_match, stored, to_put

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from typing_extensions import Unpack

    from .contract import ToolDocument, WearEntry, WearEntryRequest, WearTrendDocument


class Tool:
    """A tool of a machine. Making one asks nothing of the service."""

    def __init__(self, connection: Connection, machine_path: str, tool_id: str) -> None:
        self._connection = connection
        self.id = tool_id
        self.path = f"{machine_path}/tools/{part(tool_id)}"

    def __repr__(self) -> str:
        return f"<Tool {self.id}>"

    def get(self) -> Stored[ToolDocument]:
        """The tool with its tag."""
        return stored(self._connection.send("GET", self.path))

    def put(
        self,
        tool: ToolProfile | ToolDocument | Stored[ToolDocument],
        *,
        replace: str | Stored[ToolDocument] | None = None,
    ) -> Stored[ToolDocument]:
        """Stores the tool. To replace one, give back what `get` gave, or name it with `replace`."""
        if isinstance(tool, Stored):
            replace = replace or tool
        document: Any = to_put(tool, ToolProfile)
        return stored(self._connection.send("PUT", self.path, document=document, headers=if_match(replace)))

    def delete(self, stored: str | Stored[ToolDocument]) -> None:
        """Deletes the tool, if it is still as it was read. Its wear entries stay."""
        self._connection.send("DELETE", self.path, headers=if_match(stored))

    def revisions(self) -> Iterator[ToolDocument]:
        """Every revision, newest first."""
        return self._connection.pages(f"{self.path}/revisions", {})

    def revision(self, revision: int) -> ToolDocument:
        """One revision."""
        return cast("ToolDocument", self._connection.get(f"{self.path}/revisions/{revision}"))

    def add_wear(self, *, idempotency_key: str | None = None, **entry: Unpack[WearEntryRequest]) -> WearEntry:
        """Stores one wear entry."""
        return cast("WearEntry", self._add(entry, idempotency_key))

    def add_wear_entries(
        self, entries: Iterable[WearEntryRequest], *, idempotency_key: str | None = None
    ) -> list[WearEntry]:
        """Stores several wear entries: all, or none if one is wrong."""
        return cast("list[WearEntry]", self._add(list(entries), idempotency_key))

    def _add(self, document: Any, idempotency_key: str | None) -> Any:
        headers = {"Idempotency-Key": idempotency_key or new_idempotency_key()}
        return self._connection.send("POST", f"{self.path}/wear-entries", document=document, headers=headers).json()

    def wear_entries(self, *, cutter_id: str | None = None) -> Iterator[WearEntry]:
        """The wear entries, newest first. Withdrawn entries stay in the list."""
        return self._connection.pages(f"{self.path}/wear-entries", {"cutter_id": cutter_id})

    def withdraw_wear(self, entry_id: str, reason: str) -> WearEntry:
        """Withdraws a wrong entry. Then store the right one."""
        path = f"{self.path}/wear-entries/{part(entry_id)}/withdraw"
        return cast("WearEntry", self._connection.send("POST", path, document={"reason": reason}).json())

    def wear_trend(self, *, limit_um: float | None = None, cutter_id: str | None = None) -> WearTrend:
        """The course of the wear, and with `limit_um` the number of parts that are left."""
        return WearTrend(self._connection, f"{self.path}/wear-trend", {"limit_um": limit_um, "cutter_id": cutter_id})


class WearTrend:
    """The course of the wear of a cutter."""

    def __init__(self, connection: Connection, path: str, query: dict[str, Any]) -> None:
        self._connection, self._path, self._query = connection, path, query
        self.document: WearTrendDocument = connection.get(path, query=query)

    @property
    def words(self) -> str | None:
        """How many parts are left, in words."""
        outlook = self.document.get("outlook")
        return None if outlook is None else outlook["words"]

    def __repr__(self) -> str:
        return f"<WearTrend {self.document['tool_id']}: {self.words or 'no limit given'}>"

    def figure(self) -> Figure:
        """The entries, the fitted course, the limit and the outlook."""
        return Figure(self._connection.send("GET", self._path, query=self._query, accept=SVG).text)

    def table(self) -> dict[str, NDArray[Any]]:
        """The entries as one array for each column."""
        return arrays.records_of(self._connection.send("GET", self._path, query=self._query, accept=CSV).text)

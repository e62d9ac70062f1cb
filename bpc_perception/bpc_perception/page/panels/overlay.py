"""The camera's image with what was measured."""

from __future__ import annotations

from nicegui import ui

from bpc_perception.page import elements
from bpc_perception.page.board import Overlay


class OverlayPanel:
    """The newest overlay, which opens in full size; before the first, a note."""

    def __init__(self) -> None:
        with elements.card('overlay', 'Camera'):
            with ui.link(target='/overlay.jpg', new_tab=True) as self._link:
                self._image = ui.interactive_image().classes('overlay')
            self._note = ui.label('The picture comes with the next measured capture.'
                                  ).classes('quiet')

    def show(self, overlay: Overlay | None) -> None:
        """Show an overlay; None = there is none yet."""
        if overlay is not None:
            # The stamp makes the address a new one, so that the browser loads it.
            address = f'/overlay.jpg?capture={overlay.stamp_ns}'
            self._image.set_source(address)
            self._link.props['href'] = address
        self._link.set_visibility(overlay is not None)
        self._note.set_visibility(overlay is None)

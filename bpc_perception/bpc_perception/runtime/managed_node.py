"""A node with the managed lifecycle of ROS 2 that says why it does not change its state."""

from __future__ import annotations

from collections.abc import Callable
import traceback
from typing import Any

from lifecycle_msgs.srv import ChangeState
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn

from bpc_perception.runtime.diagnostics import Diagnostics

ACTIVE = 'active'


class ManagedNode(LifecycleNode):  # type: ignore[misc]
    """Changes its state on request, or reports on /diagnostics why not.

    On Jazzy, rclpy drops what a transition raises. For a transition that is not possible in the
    state of the node it raises an error itself, which would end the process.
    """

    # A transition may fail with these, and can be tried again.
    EXPECTED: tuple[type[Exception], ...] = (ValueError, OSError)

    def __init__(self, name: str, **kwargs: Any) -> None:
        super().__init__(name, **kwargs)
        self._diagnostics = Diagnostics(self)
        self._failure: Exception | None = None
        self._change_state = self._service_change_state.callback
        self._service_change_state.callback = self._on_change_state
        self._diagnostics.note('state', self.state)

    def configure(self) -> None:
        """Acquire what the node needs."""
        raise NotImplementedError

    def activate(self) -> None:
        """Start working."""
        raise NotImplementedError

    def deactivate(self) -> None:
        """Stop working."""
        raise NotImplementedError

    def clean_up(self) -> None:
        """Release everything, in any state."""
        raise NotImplementedError

    @property
    def state(self) -> str:
        """Name of the current state."""
        return str(self._state_machine.current_state[1])

    def start(self) -> None:
        """Become active at once. Raises the error that prevents it."""
        for trigger in self.trigger_configure, self.trigger_activate:
            if trigger() != TransitionCallbackReturn.SUCCESS:
                assert self._failure is not None
                raise self._failure
        self._diagnostics.note('state', self.state)

    def on_configure(self, _: LifecycleState) -> TransitionCallbackReturn:
        """From unconfigured to inactive."""
        return self._attempt(self.configure)

    def on_activate(self, _: LifecycleState) -> TransitionCallbackReturn:
        """From inactive to active."""
        return self._attempt(self.activate)

    def on_deactivate(self, _: LifecycleState) -> TransitionCallbackReturn:
        """From active to inactive."""
        return self._attempt(self.deactivate)

    def on_cleanup(self, _: LifecycleState) -> TransitionCallbackReturn:
        """From inactive to unconfigured."""
        return self._attempt(self.clean_up)

    def on_error(self, _: LifecycleState) -> TransitionCallbackReturn:
        """From anywhere to unconfigured."""
        return self._attempt(self.clean_up)

    def on_shutdown(self, _: LifecycleState) -> TransitionCallbackReturn:
        """From anywhere to finalized."""
        return self._attempt(self.clean_up)

    def _attempt(self, work: Callable[[], None]) -> TransitionCallbackReturn:
        try:
            work()
        except self.EXPECTED as error:
            self._failure = error
            return TransitionCallbackReturn.FAILURE
        except Exception as error:
            self._failure = error
            self.get_logger().error(traceback.format_exc())
            return TransitionCallbackReturn.ERROR
        return TransitionCallbackReturn.SUCCESS

    def _on_change_state(self, request: ChangeState.Request,
                         response: ChangeState.Response) -> ChangeState.Response:
        before, self._failure = self.state, None
        try:
            response = self._change_state(request, response)
        except rclpy_implementation.RCLError:
            response.success = False
        if not response.success:
            asked = request.transition.label or request.transition.id
            self._diagnostics.refuse(self._failure or (
                f'transition: expected one that is possible while {before}, found {asked}'))
        self._diagnostics.note('state', self.state)
        return response

    def destroy_node(self) -> None:
        """Release everything as well."""
        self.clean_up()
        super().destroy_node()

"""Publishes what came of each capture: profile, advice, schedule, verdict, design and repair."""

from __future__ import annotations

from rclpy.node import Node

from bpc_interfaces.msg import (
    DesignComparison,
    PrintVerdict as PrintVerdictMsg,
    RateAdvice as RateAdviceMsg,
    RateSchedule,
    RepairPlan as RepairPlanMsg,
)
from bpc_perception.core.advice.rate_advice import RateAdvice
from bpc_perception.core.inspection.verdict import PrintVerdict
from bpc_perception.core.learning.layer_schedule import LayerSchedule
from bpc_perception.core.repair.plan import RepairPlan
from bpc_perception.core.result import Result
from bpc_perception.messages import topics
from bpc_perception.messages.results.advice import advice_to_message
from bpc_perception.messages.results.design import design_to_message, no_design
from bpc_perception.messages.results.repair import repair_to_message
from bpc_perception.messages.results.schedule import schedule_to_message
from bpc_perception.messages.results.verdict import verdict_to_message
from bpc_perception.nodes.parts.profile_publisher import ProfilePublisher


class ResultPublisher:
    """Publishes results of captures that were measured.

    Args:
        node: whose topics they are.
        frame: robot base frame.
        designed: whether there is a design; else the topic beside it is not there.
    """

    def __init__(self, node: Node, frame: str, designed: bool) -> None:
        self._frame = frame
        self._profiles = ProfilePublisher(node, frame)
        self._advice = node.create_publisher(RateAdviceMsg, topics.ADVICE, topics.RESULT_QOS)
        self._verdicts = node.create_publisher(PrintVerdictMsg, topics.VERDICT, topics.RESULT_QOS)
        self._schedules = node.create_publisher(RateSchedule, topics.SCHEDULE,
                                                topics.SCHEDULE_QOS)
        self._told: LayerSchedule | None = None  # the newest schedule
        self._designs = node.create_publisher(
            DesignComparison, topics.DESIGN, topics.RESULT_QOS) if designed else None
        self._repairs = node.create_publisher(RepairPlanMsg, topics.REPAIR, topics.REPAIR_QOS)
        self._plan = RepairPlan.none(0)  # that was published last

    def publish(self, result: Result, longest_whole: int) -> None:
        """Publish a result that has a profile; of a longer one than this, what is new in it."""
        profile = result.profile
        assert profile is not None
        assert result.advice is not None
        assert result.verdict is not None
        self._profiles.publish(profile, longest_whole)
        self._advice.publish(advice_to_message(result.advice))
        self._verdicts.publish(verdict_to_message(result.verdict, self._frame))
        if result.schedule is not None:
            self.tell(result.schedule)
        if self._designs is not None and result.design is not None:
            self._designs.publish(design_to_message(
                result.design.findings, profile.print_id, profile.stamp_ns, self._frame))
        if result.repair is not None:
            self._propose(result.repair)

    def tell(self, schedule: LayerSchedule) -> None:
        """Publish a schedule, if it is another than the newest."""
        if schedule is not self._told:
            self._told = schedule
            self._schedules.publish(schedule_to_message(schedule, self._frame))

    def complete(self) -> None:
        """Publish what a print that has ended leaves to be told.

        That is its whole profile, if it was not sent whole, and that its last layer is finished.
        """
        self._profiles.complete()
        plan = self._plan.at_its_end()
        if len(plan.finished) > len(self._plan.finished):
            self._propose(plan)

    def clear(self, now_ns: int, schedule: LayerSchedule) -> bool:
        """Tell who knows of a print that there is none any more; return whether anyone does.

        The schedule is that for the next print.
        """
        if not self._profiles.told:
            return False
        self._profiles.clear(now_ns)
        self._advice.publish(advice_to_message(RateAdvice.none(now_ns)))
        self._verdicts.publish(verdict_to_message(PrintVerdict.none(now_ns), self._frame))
        self.tell(schedule)
        if self._designs is not None:
            self._designs.publish(no_design(now_ns, self._frame))
        self._propose(RepairPlan.none(now_ns))
        return True

    def _propose(self, plan: RepairPlan) -> None:
        self._plan = plan
        self._repairs.publish(repair_to_message(plan, self._frame))

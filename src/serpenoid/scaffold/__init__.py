"""Files to begin with: a few questions, a commented file that runs; and trials taken into a campaign."""

from serpenoid.scaffold.campaign import campaign
from serpenoid.scaffold.problem import problem
from serpenoid.scaffold.protocol import protocol
from serpenoid.scaffold.questions import Question, Template
from serpenoid.scaffold.robot import robot

TEMPLATES: dict[str, Template] = {"problem": problem, "robot": robot, "protocol": protocol, "campaign": campaign}

__all__ = ["TEMPLATES", "Question", "Template"]

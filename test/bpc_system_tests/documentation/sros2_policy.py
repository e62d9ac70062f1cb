"""The SROS 2 policy: what each node may publish, hear and answer, and nothing else.

The format is version 0.2.0 of the design article "ROS 2 Security Enclaves", as ros2/sros2 of Jazzy
reads it (policy.xsd).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from bpc_perception.messages import topics

FILE = Path(topics.__file__).parents[2] / 'sros2' / 'bpc.policy.xml'
# What any node of rclpy has beside its own.
PUBLISHES = ('rosout', '/parameter_events')
HEARS = ('/clock', '/parameter_events')
ANSWERS = tuple(f'~/{name}' for name in (
    'describe_parameters', 'get_parameter_types', 'get_parameters', 'get_type_description',
    'list_parameters', 'set_parameters', 'set_parameters_atomically'))
# Where a flange's pose may come from.
POSES = (*topics.POSES, '/tf', '/tf_static')
LIFECYCLE = tuple(f'~/{name}' for name in (
    'change_state', 'get_available_states', 'get_available_transitions', 'get_state',
    'get_transition_graph'))
SERVICES = ('start', 'stop', 'clear', 'save')
RECORDED = tuple(topics.CAMERA | topics.PRINT | topics.ROBOT | topics.RESULTS)


@dataclass(frozen=True)
class Interface:
    """What a node publishes, hears, answers and asks beside what every node does."""

    publishes: tuple[str, ...] = ()
    hears: tuple[str, ...] = ()
    answers: tuple[str, ...] = ()
    asks: tuple[str, ...] = ()


NODES = {
    'camera_driver': Interface((*topics.CAMERA, topics.SNR, '~/transition_event', '/diagnostics'),
                               (), ('capture', *LIFECYCLE)),
    'thickness': Interface(
        (topics.PROFILE, topics.PROFILE_UPDATE, topics.ADVICE, topics.VERDICT, topics.DESIGN,
         topics.REPAIR, topics.SCHEDULE, *topics.VIEWS, '/diagnostics'),
        (*topics.CAMERA, *POSES, topics.PATH, topics.PATH_UPDATE), (topics.SEND_PROFILE,)),
    'path_recorder': Interface(
        (topics.PATH, topics.PATH_UPDATE, topics.NAV_PATH, '/diagnostics'),
        (*POSES, topics.EXTRUSION), tuple(f'~/{name}' for name in SERVICES)),
    'extruder_bridge': Interface(
        (topics.EXTRUSION, '/diagnostics'), (topics.PLUNGER, topics.EXTRUDING)),
    'bag_recorder': Interface(('/diagnostics',), (*RECORDED, topics.LBR_STATE)),
    'robot': Interface(POSES),
    'print_controller': Interface((), (topics.ADVICE, topics.VERDICT, topics.DESIGN,
                                       topics.REPAIR, topics.SCHEDULE)),
    'page': Interface(
        (), (topics.PROFILE, topics.PROFILE_UPDATE, topics.ADVICE, topics.VERDICT, topics.DESIGN,
             topics.OVERLAY, '/diagnostics'),
        (), ('capture', topics.SEND_PROFILE, 'thickness/get_parameters',
             *(f'path_recorder/{name}' for name in SERVICES))),
    'operator': Interface((), (*RECORDED, *topics.VIEWS), (), (
        'capture', topics.SEND_PROFILE, *(f'path_recorder/{name}' for name in SERVICES))),
}
# Enclave to the nodes in its process.
ENCLAVES = {**{name: (name,) for name in NODES}, 'composed': ('camera_driver', 'thickness')}


def policy() -> str:
    """The text of the policy."""
    root = ElementTree.Element('policy', version='0.2.0')
    root.append(ElementTree.Comment(' Made by test/bpc_system_tests/documentation/reference.py. '))
    enclaves = ElementTree.SubElement(root, 'enclaves')
    for enclave, nodes in ENCLAVES.items():
        profiles = ElementTree.SubElement(
            ElementTree.SubElement(enclaves, 'enclave', path=f'/bpc/{enclave}'), 'profiles')
        for name in nodes:
            profile = ElementTree.SubElement(profiles, 'profile', ns='/', node=name)
            interface = NODES[name]
            _list(profile, 'topics', 'publish', (*PUBLISHES, *interface.publishes))
            _list(profile, 'topics', 'subscribe', (*HEARS, *interface.hears))
            _list(profile, 'services', 'reply', (*ANSWERS, *interface.answers))
            _list(profile, 'services', 'request', interface.asks)
    ElementTree.indent(root)
    return ('<?xml version="1.0" encoding="UTF-8"?>\n'
            + ElementTree.tostring(root, encoding='unicode') + '\n')


def _list(profile: ElementTree.Element, kind: str, action: str, names: tuple[str, ...]) -> None:
    if not names:
        return
    entries = ElementTree.SubElement(profile, kind, {action: 'ALLOW'})
    for name in dict.fromkeys(names):
        ElementTree.SubElement(entries, kind.removesuffix('s')).text = name

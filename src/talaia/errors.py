"""Every error the product raises on purpose.

TalaiaError
├── DescriptionError      model.errors      the site description is wrong
│   ├── UnknownWord       model.errors      a word that is not in a closed list
│   └── NotReadable       model.errors      the file is missing or is not YAML
├── NotAProbe             model.discovery   what was read is not what a probe writes
├── PeerError             wire.errors       the other side broke the protocol
├── PlannerError          planner.errors    the planner cannot plan with what it was given
├── GatewayError          gateway.errors    a robot, a device or the spool failed
├── HubError              hub.errors        the hub cannot start or go on
├── SimError              sim.errors        the simulated robot cannot run here
├── ForeignRos            ros_installation  there is no ROS 2 here that could be used
├── ConfiguratorError     configurator.errors  what was asked for in the window cannot be done
├── ClientError           client.errors     a script cannot ask the hub, or the hub says no
└── CliError              cli.errors        what the user asked for cannot be started
"""

from __future__ import annotations

__all__ = ["TalaiaError"]


class TalaiaError(Exception):
    """Base of the tree above; catch it at the edge of a process, nowhere else."""

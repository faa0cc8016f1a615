"""Time-correlated demands, from a simulated rigid vehicle under a tracking controller.

``body`` has the equations of motion; ``simulate`` has the controller and flies the mission, through a
failure half way. The sets ``mission`` and ``mission-fault`` are the mission's two halves.
"""

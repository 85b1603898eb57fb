"""Behaviours of py_trees and of other packages as nodes: what their classes take, and what ticks them.

| module | holds |
|---|---|
| written.py | which values of Python a tree file can write |
| arguments.py | the constructor arguments of a class |
| class_ports.py | what its `INPUT_PORTS` and `OUTPUT_PORTS` declare |
| of_class.py | the node that a class gives, or why it gives none |
| board.py | values handed over through the Blackboard of py_trees |
| node.py | the node that ticks the behaviour |
"""

"""Wiring of nodes and calls: their ports, the records that are left out, and their devices."""

from __future__ import annotations

from typing import Any

from stretch_bt.source import Map, Mark, Scalar, Value, did_you_mean, is_nothing, is_null
from stretch_bt.tree import registry
from stretch_bt.tree.document import DeviceDecl, Param, Signature
from stretch_bt.tree.expression.parse import Name
from stretch_bt.tree.expression.typecheck import Origin
from stretch_bt.tree.flow import Call, Leaf, Part, Wire
from stretch_bt.tree.keys import settle_types
from stretch_bt.tree.node_info import NodeInfo
from stretch_bt.tree.port import Port, Role
from stretch_bt.tree.shared_signatures import shared_signatures
from stretch_bt.tree.types import ANY, STR, Type
from stretch_bt.tree.values import braces, literal_type, sample
from stretch_bt.tree.wiring import Wiring

__all__ = ["NodeWiring", "givers"]


class NodeWiring(Wiring):
    """Wires the ports of nodes and of trees that are called."""

    def port_map(self, value: Value, mark: Mark, what: str, required: list[str]) -> Map | None:
        """Return the wiring written after a name; nothing written means none."""
        if isinstance(value, Map):
            return value
        if is_nothing(value):
            return Map((), mark)
        if is_null(value):
            self.error(
                value.mark, "value-missing", f"{what!r} is given null", "write its ports, or nothing after the colon"
            )
            return None
        given = value.text if isinstance(value, Scalar) and len(required) == 1 else "..."
        ports = ", ".join(f"{name}: {given}" for name in required) or "port: value"
        self.error(value.mark, "type-mismatch", f"{what!r} takes a mapping of ports", f"write '{what}: {{{ports}}}'")
        return None

    def leaf(self, info: NodeInfo, mark: Mark, value: Value) -> Part | None:
        """Read a node and wire its ports."""
        required = [p.name for p in info.ports.values() if p.required]
        ports = self.port_map(value, mark, info.name, required)
        found = Leaf(mark, info)
        if ports is None:
            return None
        outputs, inouts = info.outputs, info.inouts
        meant = self.unknown(ports, info.name, [*info.ports, *outputs], required)
        for key, given in ports:
            self.wire_port(found, key, given)
        self.records_in(found, {p.name: (info.types[p.name], p.required) for p in info.of(Role.INPUT)}, ports, mark)
        self.records_out(found, outputs, ports, mark)
        self.records_both(found, inouts, ports, mark)
        for name in required:
            carried = name.endswith("_sd") and found.inputs.get(name.removesuffix("_sd"))
            if (
                name not in ports
                and name not in meant
                and name not in found.inputs
                and name not in found.inouts
                and not (carried and self._may_carry(carried))
            ):
                self.missing(mark, info.name, name, info.types[name], over=name in inouts)
        for declared in info.of(Role.DEVICE):
            if declared.name not in ports or is_nothing(ports.get(declared.name) or Map((), mark)):
                self.default_device(found, declared, mark)
        return found

    def wire_port(self, found: Leaf, key: Scalar, value: Value) -> None:
        """Wire one port of a node; a key that names none was noted before."""
        info, what = found.info, f"{found.info.name}.{key.text}"
        declared = info.ports.get(key.text)
        if declared is not None and declared.role is Role.DEVICE:
            if not is_nothing(value):
                self.device(found, declared, value)
            return
        given = self.full(key, value)
        if given is None:
            return
        if declared is not None and declared.fixed:
            self.argument(found, key, given, declared)
        elif declared is not None and declared.role is Role.INPUT:
            self.input(found.inputs, key, given, info.types[key.text], what, declared)
        elif key.text in info.inouts:
            self.sink(found.inouts, key, given, info.inouts[key.text], what, "inout")
        elif key.text in info.outputs:
            self.sink(found.outputs, key, given, info.outputs[key.text], what)

    def argument(self, found: Leaf, key: Scalar, value: Value, declared: Port) -> None:
        """Wire a constructor argument of a behaviour: a value that is known at load, as the behaviour is made once."""
        type_, what = found.info.types[declared.name], f"{found.info.name}.{declared.name}"
        name = value.text[1:] if isinstance(value, Scalar) and value.text.startswith("$") else ""
        late = self.signature.declared(name) is not None
        if not late:
            self.input(found.inputs, key, value, self.type_given(value) if type_ is ANY else type_, what, declared)
            wire = found.inputs.get(key.text)
            late = wire is not None and not wire.is_constant
        if late:
            found.inputs.pop(key.text, None)
            message = f"{what} is given as the behaviour is made, so its value must be known at load"
            self.error(value.mark, "type-mismatch", message, "use a literal or a param")

    def type_given(self, value: Value) -> Type:
        """Return the type of a literal, or of a param, for an argument of any type; a mapping has none."""
        param = self.document.params.get(value.text.removeprefix("$")) if isinstance(value, Scalar) else None
        plain = STR if isinstance(value, Map) else literal_type(value)
        return plain if param is None else param.type

    def records_in(self, found: Leaf | Call, inputs: dict[str, tuple[Type, bool]], ports: Map, mark: Mark) -> None:
        """Wire each record that is left out to the key of its name, where there is one."""
        for name, (type_, required) in inputs.items():
            declared = self.signature.declared(name)
            if name not in ports and type_.is_record and declared is not None and type_.accepts(declared.type):
                wire = self.value(Scalar(f"${name}", False, mark), type_, f"{found.label}.{name}")
                if wire is not None:
                    wire.optional = not required
                    found.inputs[name] = wire
                    found.left_out.add(name)

    def variant(self, target: Signature, ports: Map) -> tuple[Signature, Map]:
        """Return the tree with the params of its file that a call gives, and what else the call gives."""
        document = target.document
        given = {
            key.text: (key, value)
            for key, value in ports
            if target.declared(key.text) is None and key.text in document.params and document.reread is not None
        }
        if not given:
            return target, ports
        values = {name: self.param_of_call(document.params[name], *pair) for name, pair in given.items()}
        known = {name: value for name, value in values.items() if value is not None}
        made = document.with_params(known).trees[target.name]
        self.diagnostics += settle_types(made)
        return made, Map(tuple(pair for pair in ports if pair[0].text not in given), ports.mark)

    def _may_carry(self, wire: Wire) -> bool:
        """Whether the value of a wire may have an error: that of a key, or of a param that has one beside it."""
        if not isinstance(wire.source, Name):
            return wire.source is not None
        symbol = self.scope.resolve(wire.source.parts)
        if symbol.origin is Origin.PARAM:
            return f"{symbol.name}_sd" in self.signature.document.params and symbol.used == len(wire.source.parts)
        return symbol.origin is Origin.KEY

    def param_of_call(self, param: Param, key: Scalar, value: Value) -> Any:
        """Return the value that a call gives a param of the file that it calls; None, with an error, where it is not known at load."""
        full = self.full(key, value)
        wire = self.value(full, param.type, key.text, param.min, param.max) if full is not None else None
        if wire is not None and not wire.is_constant:
            message = f"{key.text!r} is a param of the file, so its value must be known at load"
            self.error(value.mark, "type-mismatch", message, "use a literal or a param")
        return wire.value if wire is not None and wire.is_constant else None

    def devices_of_call(self, target: Signature, ports: Map) -> tuple[dict[str, str], Map]:
        """Return which device a call gives for each that the tree finds by name, and what else the call gives."""
        found: dict[str, str] = {}
        rest = []
        for key, value in ports:
            name = value.text.removeprefix("$") if isinstance(value, Scalar) else ""
            if name in self.document.doubtful_devices and target.declared(key.text) is None:
                continue
            outer = target.document.devices.get(key.text)
            if outer is None or target.declared(key.text) is not None or target.document.declares_devices:
                rest.append((key, value))
                continue
            given = self.document.devices.get(name)
            if given is None or given.interface is not outer.interface:
                kind = outer.interface.__name__
                message = f"{target.name}.{key.text} takes {kind}, and {name or 'this'!r} is none"
                self.error(value.mark, "device-undeclared", message, self.fitting(kind))
            else:
                given.used = True
                found[key.text] = name
        return found, Map(tuple(rest), ports.mark)

    def records_both(self, found: Leaf | Call, inouts: dict[str, Type], ports: Map, mark: Mark) -> None:
        """Wire each record that is read and written over, and that is left out, to the key of its name."""
        for name, type_ in inouts.items():
            if name in ports or not type_.is_record:
                continue
            declared = self.signature.declared(name)
            if declared is not None and declared.type.accepts(type_) and name not in self.signature.ins:
                found.inouts[name] = (name, mark)
                found.left_out.add(name)
            elif declared is not None or name in self.document.params:
                self.not_written_over(found, name, mark)

    def not_written_over(self, found: Leaf | Call, name: str, mark: Mark) -> None:
        """Note a record that is left out and whose name is another thing, so that nothing keeps what is written over it."""
        message = f"{found.label!r} writes over {name!r}, and ${name} is something else here"
        hint = f"give it a key of its own: '{name}: $other'"
        if name in self.signature.ins:
            message = f"{found.label!r} writes over {name!r}, and ${name} is an input, which is never written"
            hint = f"declare it as 'inout: [{name}]'"
        self.error(mark, "input-written", message, hint)

    def records_out(self, found: Leaf | Call, outputs: dict[str, Type], ports: Map, mark: Mark) -> None:
        """Write each record that is left out to the key of its name, where something reads that."""
        for name, type_ in outputs.items():
            declared = self.signature.declared(name)
            if name in ports or not type_.is_record or declared is None or not declared.type.accepts(type_):
                continue
            if name in self.signature.read and name not in self.signature.ins:
                found.outputs[name] = (name, mark)
                found.left_out.add(name)

    def missing(self, mark: Mark, what: str, name: str, type_: Type, *, over: bool = False) -> None:
        """Note an input that must be given and is not; one that is written `over` as well takes a key alone."""
        hint = f"add '{name}: {'$key' if over else sample(type_)}'"
        if type_.is_record:
            by = ", ".join(map(repr, givers(type_)[:3])) or "some node"
            hint = f"nothing before it writes {name!r}; {by} gives one, or {hint}"
        kind = f"{type_}, an inout" if over else str(type_)
        self.error(mark, "port-missing", f"{what!r} needs {name!r} ({kind})", hint)

    def device(self, found: Leaf, declared: Port, value: Value) -> None:
        """Wire a device port to a declared device."""
        name = value.text.removeprefix("$") if isinstance(value, Scalar) else ""
        decl = self.document.devices.get(name)
        if decl is None:
            if name in self.document.doubtful:
                return
            self.error(
                value.mark,
                "device-undeclared",
                f"no device {name!r} is declared",
                braces(value)
                or did_you_mean(name, self.document.devices)
                or self.fitting(found.info.types[declared.name].name),
            )
            return
        decl.used = True
        wanted = found.info.types[declared.name].name
        if decl.interface.__name__ != wanted:
            message = f"{found.info.name}.{declared.name} takes {wanted}, but {name!r} is {decl.interface.__name__}"
            self.error(value.mark, "type-mismatch", message, self.fitting(wanted))
        found.devices[declared.name] = name

    def fitting(self, wanted: str) -> str:
        """Return which device of the file is of the wanted kind."""
        names = [d.name for d in self.document.devices.values() if d.interface.__name__ == wanted]
        return f"write '{names[0]}'" if names else f"declare one: 'devices: {{name: {wanted}}}'"

    def default_device(self, found: Leaf, declared: Port, mark: Mark) -> None:
        """Wire a device port that is not written: the device of its name, or the only one of its kind."""
        wanted = found.info.types[declared.name].name
        fitting = [d for d in self.document.devices.values() if d.interface.__name__ == wanted]
        named_so = [d for d in fitting if d.name == declared.name]
        chosen = named_so or fitting
        if len(chosen) == 1:
            chosen[0].used = True
            found.devices[declared.name] = chosen[0].name
        elif not declared.optional and not (self.document.doubtful and not chosen):
            self.error(mark, "device-undeclared", *self._no_device(found, declared.name, wanted, chosen))

    def _no_device(self, found: Leaf, port: str, wanted: str, fitting: list[DeviceDecl]) -> tuple[str, str]:
        """Return what is wrong where no device, or more than one, is of the kind that a node needs, and the remedy."""
        doc = self.document
        what = f"{found.info.name!r} needs a device of kind {wanted}, and "
        if not fitting:
            return f"{what}the file declares none", f"add 'devices: {{{port}: {wanted}}}'"
        if doc.declares_devices or not doc.prefix:
            return f"{what}the file declares several", f"write '{port}: {fitting[0].name}'"
        what += f"this file declares none, and the task several, none of them called {port!r}"
        another = f"'{self.signature.qualified}: {{{port}: {fitting[-1].name}}}'"
        return what, f"call {fitting[0].name!r} {port!r} in the task; a call may give another: {another}"

    def call(self, target: Signature, mark: Mark, value: Value) -> Part | None:
        """Read a call of a tree and wire what crosses its border; params of its file, and devices, may be given too."""
        ports = self.port_map(value, mark, target.name, [d.name for d in target.ins.values() if not d.has_default])
        if ports is None:
            return None
        target, ports = self.variant(target, ports)
        devices, ports = self.devices_of_call(target, ports)
        required = [d.name for d in target.ins.values() if not d.has_default and not d.doubtful]
        found = Call(mark, target, devices=devices)
        required += [d.name for d in target.inouts.values() if not d.has_default]
        params = target.document.params if target.document.reread is not None else ()
        deviations = target.deviations
        known = [*target.ins, *target.inouts, *target.outs, *deviations, *params]
        meant = self.unknown(ports, target.name, known, required)
        for key, value_given in ports:
            given = self.full(key, value_given)
            if given is None:
                continue
            if key.text in target.ins:
                declared = target.ins[key.text]
                self.input(found.inputs, key, given, declared.type, f"{target.name}.{key.text}", declared)
            elif key.text in target.inouts:
                self.sink(found.inouts, key, given, target.inouts[key.text].type, f"{target.name}.{key.text}", "inout")
            elif key.text in target.outs and target.outs[key.text].scene:
                message = f"the scene alone knows {key.text!r} of {target.name!r}, and no tree may read it"
                self.error(key.mark, "output-of-scene", message, "leave it out")
            elif (out := target.outs.get(key.text) or deviations.get(key.text)) is not None:
                self.sink(found.outputs, key, given, out.type, f"{target.name}.{key.text}")
        self.records_in(found, {d.name: (d.type, not d.has_default) for d in target.ins.values()}, ports, mark)
        self.records_out(found, {d.name: d.type for d in target.outs.values() if not d.scene}, ports, mark)
        self.records_both(found, {d.name: d.type for d in target.inouts.values()}, ports, mark)
        for name in required:
            if not any(name in given for given in (ports, meant, found.inputs, found.inouts)):
                self.missing(
                    mark, target.name, name, (target.ins | target.inouts)[name].type, over=name in target.inouts
                )
        return found


def givers(type_: Type) -> list[str]:
    """Return what gives a record of a type: shipped trees first, then nodes, last those that need not have it before."""
    trees = [name for name, tree in shared_signatures().items() if type_ in [out.type for out in tree.outs.values()]]
    nodes = [info.name for info in registry.load_all().values() if type_ in info.outputs.values()]
    begun = [
        info.name
        for info in registry.load_all().values()
        if any(type_ == info.types[p.name] and not p.required for p in info.of(Role.INOUT))
    ]
    return [*trees, *nodes] or begun

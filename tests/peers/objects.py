"""The object dictionary of a CiA 402 drive, as PyPI `canopen` wants it."""

from canopen import objectdictionary as od

_TYPES = {"u8": od.UNSIGNED8, "i8": od.INTEGER8, "u16": od.UNSIGNED16, "i16": od.INTEGER16,
          "u32": od.UNSIGNED32, "i32": od.INTEGER32}


def dictionary(node):
    """Of the drive with this node number."""
    objects = od.ObjectDictionary()

    def variable(index, sub, name, kind, default, access="rw"):
        var = od.ODVariable(name, index, sub)
        var.data_type, var.default, var.access_type = _TYPES[kind], default, access
        return var

    def single(index, name, kind, default=0, access="rw"):
        objects.add_object(variable(index, 0, name, kind, default, access))

    def record(index, name, *members):
        group = od.ODRecord(name, index)
        for sub, (member, kind, default) in enumerate(members):
            group.add_member(variable(index, sub, member, kind, default))
        objects.add_object(group)

    single(0x1000, "Device type", "u32", 0x00020192, "ro")
    single(0x1001, "Error register", "u8", 0, "ro")
    single(0x1017, "Producer heartbeat time", "u16")
    record(0x1016, "Consumer heartbeat time", ("Number", "u8", 1), ("Master", "u32", 0))
    record(0x1018, "Identity", ("Number", "u8", 1), ("Vendor", "u32", 0x7E57))
    # mapped otherwise, event-driven: what a master has to change
    for communication, mapping, base, entry in (
        (0x1400, 0x1600, 0x200, 0x60400010), (0x1800, 0x1A00, 0x40000180, 0x60410010)):
        record(communication, f"PDO {communication:X}", ("Number", "u8", 2),
               ("COB-ID", "u32", base + node), ("Type", "u8", 255))
        record(mapping, f"Mapping {mapping:X}", ("Number", "u8", 1), ("1", "u32", entry), ("2", "u32", 0))
    single(0x6007, "Abort connection option code", "i16", 1)
    single(0x603F, "Error code", "u16", 0, "ro")
    single(0x6040, "Controlword", "u16")
    single(0x6041, "Statusword", "u16", 0x40, "ro")
    single(0x6060, "Modes of operation", "i8", 1)
    single(0x6061, "Modes of operation display", "i8", 1, "ro")
    single(0x6064, "Position actual value", "i32", 0, "ro")
    single(0x607A, "Target position", "i32")
    record(0x60C2, "Interpolation time period", ("Number", "u8", 2), ("Value", "u8", 1), ("Index", "i8", -3))
    single(0x6502, "Supported drive modes", "u32", 0x81, "ro")
    return objects

from tfra.hdl.lib import names as names  # names signals, whoever imports a part of the gateware

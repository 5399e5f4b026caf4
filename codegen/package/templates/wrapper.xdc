# Clock of $wrapper: $mhz MHz.  In a block design the clock comes from outside, and this line yields to it.
create_clock -name aclk -period $period [get_ports aclk]

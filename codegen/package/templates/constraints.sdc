# Clock of $name: $mhz MHz, which cores of its kind reach on $part.
# A slower clock is always right: no cycle of the core depends on it.
set period $period
foreach name {aclk clk} {
  if {[llength [get_ports -quiet $$name]] > 0} {
    create_clock -name $$name -period $$period [get_ports $$name]
  }
}
# Both resets are synchronous; frames wait until four cycles after them.
foreach name {aresetn rst} {
  if {[llength [get_ports -quiet $$name]] > 0} {
    set_multicycle_path 4 -setup -from [get_ports $$name]
    set_multicycle_path 3 -hold -from [get_ports $$name]
  }
}

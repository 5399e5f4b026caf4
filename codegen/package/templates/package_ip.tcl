# Packages $wrapper as an IP core for Vivado's catalogue:
#   vivado -mode batch -source package_ip.tcl
# The folder "ip" beside this file is then a repository: settings, IP, repository, add.
set here [file dirname [file normalize [info script]]]
set root [file dirname $$here]
set files [list [file join $$root $name.v] [file join $$root $wrapper.v]]
foreach file $$files {
  if {![file exists $$file]} { error "$$file is missing" }
}
set images [list $images]

create_project -force -in_memory -part xc7a35tcsg324-1 $wrapper
add_files -norecurse $$files
foreach image $$images {
  add_files -norecurse [file join $$root $$image]
  set_property file_type {Memory Initialization Files} [get_files [file join $$root $$image]]
}
set_property top $wrapper [current_fileset]
update_compile_order -fileset sources_1

ipx::package_project -root_dir [file join $$here ip] -vendor $vendor -library core -taxonomy /UserIP -import_files -force
set core [ipx::current_core]
set_property name $wrapper $$core
set_property version $release $$core
set_property display_name {$name} $$core
set_property description {$description} $$core
set_property supported_families {artix7 Production kintex7 Production zynq Production zynquplus Production} $$core

# Interfaces, all of them synchronous to aclk.
foreach {name kind} {s_axi aximm s_axis axis m_axis axis} {
  if {[llength [ipx::get_bus_interfaces $$name -of_objects $$core]] == 0} {
    ipx::infer_bus_interfaces xilinx.com:interface:$${kind}_rtl:1.0 $$core
  }
  ipx::associate_bus_interfaces -busif $$name -clock aclk $$core
}
ipx::infer_bus_interface aresetn xilinx.com:signal:reset_rtl:1.0 $$core
ipx::infer_bus_interface irq xilinx.com:signal:interrupt_rtl:1.0 $$core
ipx::associate_bus_interfaces -clock aclk -reset aresetn $$core
set_property value ACTIVE_LOW [ipx::add_bus_parameter POLARITY [ipx::get_bus_interfaces aresetn -of_objects $$core]]
set_property value LEVEL_HIGH [ipx::add_bus_parameter SENSITIVITY [ipx::get_bus_interfaces irq -of_objects $$core]]

# Registers.
foreach map [ipx::get_memory_maps -of_objects $$core] { ipx::remove_memory_map [get_property name $$map] $$core }
set map [ipx::add_memory_map s_axi $$core]
set_property slave_memory_map_ref s_axi [ipx::get_bus_interfaces s_axi -of_objects $$core]
set block [ipx::add_address_block registers $$map]
set_property range 256 $$block
set_property width 32 $$block
set_property usage register $$block

proc register {name address access text fields} {
  global block
  set register [ipx::add_register $$name $$block]
  set_property address_offset $$address $$register
  set_property size 32 $$register
  set_property access $$access $$register
  set_property description $$text $$register
  foreach {field low bits access text} $$fields {
    set field [ipx::add_field $$field $$register]
    set_property bit_offset $$low $$field
    set_property bit_width $$bits $$field
    set_property access $$access $$field
    set_property description $$text $$field
  }
}

$registers

ipx::create_xgui_files $$core
ipx::update_checksums $$core
ipx::check_integrity $$core
ipx::save_core $$core

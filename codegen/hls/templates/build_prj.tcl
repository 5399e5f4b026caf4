# vitis_hls -f build_prj.tcl "csim=1 synth=1 cosim=1 export=1 part=$part period=$period"
array set opt {csim 1 synth 1 cosim 0 export 0 part $part period $period}
foreach argument $$argv {
    foreach {all key value} [regexp -all -inline {(\w+)=(\S+)} $$argument] {
        set opt($$key) $$value
    }
}

open_project -reset ${name}_prj
set_top $name
add_files firmware/$name.cpp -cflags "-std=c++14"
add_files -tb ${name}_test.cpp -cflags "-std=c++14"
add_files -tb tb_data
open_solution -reset solution1 -flow_target vivado
set_part $$opt(part)
create_clock -period $$opt(period)
config_rtl -reset state

if {$$opt(csim)} { csim_design }
if {$$opt(synth)} { csynth_design }
if {$$opt(cosim)} { cosim_design }
if {$$opt(export)} { export_design -format ip_catalog -ipname $name }
exit

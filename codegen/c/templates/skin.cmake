
target_sources($name PRIVATE ${name}_skin.c)
add_executable(${name}_skin_test ${name}_skin_test.c)
target_link_libraries(${name}_skin_test $name)
set_target_properties(${name}_skin_test PROPERTIES C_STANDARD 99 C_STANDARD_REQUIRED ON)
add_test(NAME recorded_contacts COMMAND ${name}_skin_test)

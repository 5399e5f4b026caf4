-- $wrapper for projects in VHDL: its component, and constants of this design.
--
--   use work.${wrapper}_pkg.all;
--   ...
--   core: $wrapper port map (aclk => clock, ...);
--
-- C_... are what the registers state (registers/tfra.html), AT_... their byte addresses.
library ieee;
use ieee.std_logic_1164.all;

package ${wrapper}_pkg is

$constants

  component $wrapper is
    port (
$ports
    );
  end component;

end package;

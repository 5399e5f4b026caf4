// SB_SPRAM256KA of the iCE40 UltraPlus: 16,384 words of 16 bits behind one port, unknown at first, and while it writes.
// Standby, sleep and power-off are not modelled: they are fatal.
module SB_SPRAM256KA (
  input [13:0] ADDRESS,
  input [15:0] DATAIN,
  input [3:0] MASKWREN,  // of four bits each
  input WREN, CHIPSELECT, CLOCK, STANDBY, SLEEP, POWEROFF,
  output reg [15:0] DATAOUT
);
  reg [15:0] words [0:16383];
  wire [15:0] mask = {{4{MASKWREN[3]}}, {4{MASKWREN[2]}}, {4{MASKWREN[1]}}, {4{MASKWREN[0]}}};

  always @(posedge CLOCK) begin
    if (STANDBY || SLEEP || !POWEROFF) $fatal(1, "SB_SPRAM256KA: only normal operation is modelled");
    if (CHIPSELECT) begin
      if (WREN) words[ADDRESS] <= DATAIN & mask | words[ADDRESS] & ~mask;
      DATAOUT <= WREN ? 16'bx : words[ADDRESS];
    end
  end
endmodule

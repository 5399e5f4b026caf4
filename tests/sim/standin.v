// Stands in for a core: takes frames of TAXELS codes, and replays the words of words.hex, WORDS a frame.
// setup.hex holds the kind of fault and the number of the word it hits:
//   0 none, 1 corrupt the word, 2 drop its last, 3 drop the word, 4 change it while it waits,
//   5 withdraw valid once while it waits, 6 stop for good before it, 7 send one word too many after it.
module standin (
    input wire clk,
    input wire rst,
    input wire signed [@ADC@-1:0] taxel_data,
    input wire taxel_valid,
    output wire taxel_ready,
    output wire signed [@BITS@-1:0] result_data,
    output wire result_last,
    output wire result_valid,
    input wire result_ready
);
  localparam TAXELS = @TAXELS@, WORDS = @WORDS@, MOST = 4096;
  reg [63:0] words[0:MOST-1];
  reg [31:0] setup[0:1];
  initial begin
    $readmemh("words.hex", words);
    $readmemh("setup.hex", setup);
  end
  reg [15:0] taken, sent, place, owed;
  reg [3:0] wait_cycles;
  reg [1:0] held;
  wire here = sent == setup[1][15:0];
  wire [31:0] fault = here ? setup[0] : 0;
  wire waiting = owed != 0 & wait_cycles == 0;
  wire skip = fault == 3 & waiting;
  wire surplus = setup[0] == 7 & sent == setup[1][15:0] + 1 & owed == 0;
  wire step = skip | (result_valid & result_ready);

  assign taxel_ready = owed == 0;
  assign result_valid = surplus | (waiting & ~skip & ~(fault == 5 & held == 1) & ~(fault == 6));
  assign result_data = words[sent] ^ (fault == 1 | (fault == 4 & held != 0));
  assign result_last = place == WORDS - 1 & ~(fault == 2);

  // What a testbench may watch between the blocks, here the input itself.
  wire probe_input = taxel_valid & taxel_ready;
  wire [@ADC@-1:0] probe_input_words = taxel_data ^ (setup[0] == 1);

  always @(posedge clk)
    if (rst) begin
      {taken, sent, place, owed, wait_cycles, held} <= 0;
    end else begin
      if (owed != 0 & wait_cycles != 0) wait_cycles <= wait_cycles - 1;
      if (probe_input) begin
        taken <= taken + 1;
        if (taken == TAXELS - 1) begin
          taken <= 0;
          owed <= WORDS;
          wait_cycles <= 5;
        end
      end
      if (result_valid & ~result_ready & held != 3) held <= held + 1;
      if (~result_valid & held == 1) held <= 2;
      if (step) begin
        held <= 0;
        sent <= sent + 1;
        place <= place == WORDS - 1 ? 0 : place + 1;
        if (owed != 0) owed <= owed - 1;
      end
    end
endmodule

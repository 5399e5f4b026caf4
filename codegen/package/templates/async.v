// Streams of $wrapper in a clock domain of their own: $wrapper between two asynchronous FIFOs.  Optional.
//
// Instantiate ${name}_async in place of $wrapper, and connect axis_clk, axis_resetn.  Hold both resets low together, for
// four cycles of the slower clock or more.  Registers and irq stay in the domain of aclk.
//
// Only pointers in Gray code cross, each bit from a register into two registers, and words that have been in their
// memory for two cycles.  Constrain all paths between the clocks to the shorter period (here, as an example, 8 ns):
//   XDC: set_max_delay -datapath_only -from [get_clocks aclk] -to [get_clocks axis_clk] 8.0, and the other way round
//   SDC: set_max_delay -from [get_clocks aclk] -to [get_clocks axis_clk] 8.0, set_min_delay ... 0, and the other way round
module ${name}_async #(
  parameter LOG2_DEPTH = 4  // of words in each FIFO
) (
  input axis_clk,
  input axis_resetn,
$declared
);
  wire [$in_top:0] in;
  wire [33:0] out;
  wire in_valid, in_ready, out_valid, out_ready;

  ${name}_async_fifo #(.WIDTH($in_top + 1), .LOG2_DEPTH(LOG2_DEPTH)) frames (
    .s_clk(axis_clk), .s_resetn(axis_resetn),
    .s_data({s_axis_tlast, s_axis_tuser, s_axis_tdata}), .s_valid(s_axis_tvalid), .s_ready(s_axis_tready),
    .m_clk(aclk), .m_resetn(aresetn), .m_data(in), .m_valid(in_valid), .m_ready(in_ready)
  );

  $wrapper core (
$pins,
    .s_axis_tdata(in[$in_top - 17:0]), .s_axis_tuser(in[$in_top - 1:$in_top - 16]), .s_axis_tlast(in[$in_top]),
    .s_axis_tvalid(in_valid), .s_axis_tready(in_ready),
    .m_axis_tdata(out[31:0]), .m_axis_tuser(out[32]), .m_axis_tlast(out[33]),
    .m_axis_tvalid(out_valid), .m_axis_tready(out_ready)
  );

  ${name}_async_fifo #(.WIDTH(34), .LOG2_DEPTH(LOG2_DEPTH)) results (
    .s_clk(aclk), .s_resetn(aresetn), .s_data(out), .s_valid(out_valid), .s_ready(out_ready),
    .m_clk(axis_clk), .m_resetn(axis_resetn),
    .m_data({m_axis_tlast, m_axis_tuser, m_axis_tdata}), .m_valid(m_axis_tvalid), .m_ready(m_axis_tready)
  );
endmodule

// FIFO of 2^LOG2_DEPTH words between two clocks; outputs are registers but for s_ready, which depends on registers alone.
module ${name}_async_fifo #(
  parameter WIDTH = 8,
  parameter LOG2_DEPTH = 4
) (
  input s_clk,
  input s_resetn,
  input [WIDTH-1:0] s_data,
  input s_valid,
  output s_ready,
  input m_clk,
  input m_resetn,
  output reg [WIDTH-1:0] m_data,
  output reg m_valid,
  input m_ready
);
  // Pointers have a bit more than addresses: they differ in it alone, by 2^LOG2_DEPTH words, when the FIFO is full.
  localparam [LOG2_DEPTH:0] FULL = 3 << (LOG2_DEPTH - 1);

  reg [WIDTH-1:0] memory [0:(1 << LOG2_DEPTH) - 1];
  reg [LOG2_DEPTH:0] head, head_gray, tail, tail_gray;
  (* async_reg = "true" *) reg [LOG2_DEPTH:0] head_meta, head_seen, tail_meta, tail_seen;
  wire [LOG2_DEPTH:0] head_next = head + 1'b1;
  wire [LOG2_DEPTH:0] tail_next = tail + 1'b1;

  assign s_ready = s_resetn && head_gray != (tail_seen ^ FULL);

  always @(posedge s_clk) begin
    tail_meta <= tail_gray;
    tail_seen <= tail_meta;
    if (s_valid && s_ready) begin
      memory[head[LOG2_DEPTH-1:0]] <= s_data;
      head <= head_next;
      head_gray <= head_next ^ (head_next >> 1);
    end
    if (!s_resetn) {head, head_gray, tail_meta, tail_seen} <= 0;
  end

  always @(posedge m_clk) begin
    head_meta <= head_gray;
    head_seen <= head_meta;
    if (!m_valid || m_ready) begin
      m_valid <= tail_gray != head_seen;
      m_data <= memory[tail[LOG2_DEPTH-1:0]];
      if (tail_gray != head_seen) begin
        tail <= tail_next;
        tail_gray <= tail_next ^ (tail_next >> 1);
      end
    end
    if (!m_resetn) {tail, tail_gray, head_meta, head_seen, m_valid} <= 0;
  end
endmodule

// Numbers go through a FIFO between two clocks, with stalls on both sides; prints FAILED at the first that is not the next.
`timescale 1ps / 1ps
module async_bench #(
  parameter S_HALF = 5000,
  parameter M_HALF = 3571,
  parameter LOG2_DEPTH = 2,
  parameter WORDS = 5000
);
  reg s_clk = 0, m_clk = 0, s_resetn = 0, m_resetn = 0, s_valid = 0, m_ready = 0, slow_source = 0;
  reg [15:0] sent = 0, due = 0;
  wire [15:0] taken;
  wire s_ready, m_valid;

  lanes_async_fifo #(.WIDTH(16), .LOG2_DEPTH(LOG2_DEPTH)) dut (
    .s_clk(s_clk), .s_resetn(s_resetn), .s_data(sent), .s_valid(s_valid), .s_ready(s_ready),
    .m_clk(m_clk), .m_resetn(m_resetn), .m_data(taken), .m_valid(m_valid), .m_ready(m_ready)
  );

  always #S_HALF s_clk = !s_clk;
  always #M_HALF m_clk = !m_clk;

  initial begin
    repeat (4) @(negedge s_clk);
    repeat (4) @(negedge m_clk);
    m_resetn = 1;
    @(negedge s_clk) s_resetn = 1;
    #(400 * WORDS * (S_HALF + M_HALF)) $display("FAILED: %0d words came", due);
    $finish;
  end

  always @(negedge s_clk) begin
    if (s_resetn && !s_valid) s_valid = slow_source ? ($random & 7) == 0 : ($random & 7) != 0;
    if (sent[5:0] == 0) slow_source = $random;
  end
  always @(posedge s_clk) if (s_valid && s_ready) begin
    sent <= #1 sent + 1;
    s_valid <= #1 0;
  end

  always @(negedge m_clk) m_ready = slow_source ? ($random & 7) != 0 : ($random & 7) == 0;
  always @(posedge m_clk) if (m_valid && m_ready) begin
    due <= due + 1;
    if (taken !== due) $display("FAILED: %0d came instead of %0d", taken, due);
    if (taken !== due || due == WORDS - 1) begin
      if (taken === due) $display("PASSED: %0d words", WORDS);
      $finish;
    end
  end
endmodule

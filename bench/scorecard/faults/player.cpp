// Plays a script to a core behind AXI, and writes what the core says.
//
// player SCRIPT ANSWERS: numbers of 32 bits.  The script has, one after the other,
//   0 gap user length word ...   a frame of so many taxels, and the next one at least `gap` cycles after its first
//   1 address value              a register is written
//   2 address                    a register is read
// and the answers have four numbers each:
//   0 facts, head, status        a result frame: its words 1, 0 and the last
//   1 errors faulty dropped      the time of a frame ends: if the interrupt is high, ERRORS, which are cleared,
//                                FAULTY_TAXEL and FRAMES_DROPPED, else 0
//   2 value 0 0                  a register was read
#include "core.h"

struct Device : Ports {
    FILE *answers;
    std::vector<unsigned> words;
    i64 cycle = 0;

    void answer(unsigned kind, unsigned a, unsigned b, unsigned c)
    {
        const unsigned four[] = {kind, a, b, c};
        std::fwrite(four, sizeof four, 1, answers);
    }
    // A cycle; whether the beat that is offered was taken.
    bool tick()
    {
        take(true);
        clock(0);
        const bool taken = top.s_axis_tvalid && ready();
        if (valid()) {
            words.push_back((unsigned)word());
            if (last()) {
                answer(0, words.size() > 1 ? words[1] : 0, words[0], words.back());
                words.clear();
            }
        }
        clock(1);
        cycle++;
        return taken;
    }
    void set(int address, unsigned value)
    {
        take(false);
        write(address, value);
    }
    unsigned get(int address)
    {
        unsigned value = 0;
        bool asking = true;
        take(false);
        top.s_axi_rready = 1;
        for (bool answered = false; !answered;) {
            top.s_axi_araddr = address;
            top.s_axi_arvalid = asking;
            clock(0);
            answered = top.s_axi_rvalid;
            value = top.s_axi_rdata;
            const bool taken = top.s_axi_arready;
            clock(1);
            asking &= !taken;
        }
        return value;
    }
    void slot(i64 gap, int user, int length, const int *script)
    {
        const i64 start = cycle;
        for (int beat = 0; beat < length || cycle - start < gap;) {
            const CODE word = beat < length ? (CODE)script[beat] : 0;
            const bool offered = beat < length;
            offer(offered, &word, 0, user);
            top.s_axis_tlast = beat == length - 1;
            beat += tick();
        }
        offer(false, nullptr, beats, 0);
        unsigned errors = 0, faulty = 0, dropped = 0;
        if (top.irq) {
            errors = get(0x48);
            faulty = get(0x74);
            dropped = get(0x68);
            set(0x48, errors);
            set(0x50, 1);
        }
        answer(1, errors, faulty, dropped);
    }
};

int main(int, char **arguments)
{
    const std::vector<int> script = items<int>(arguments[1]);
    Device device;
    device.answers = std::fopen(arguments[2], "wb");
    if (script.empty() || !device.answers)
        return 2;
    reset(device);
    for (const int *next = script.data(), *end = next + script.size(); next < end;) {
        if (next[0] == 0) {
            device.slot(next[1], next[2], next[3], next + 4);
            next += 4 + next[3];
        } else if (next[0] == 1) {
            device.set(next[1], (unsigned)next[2]);
            next += 3;
        } else {
            device.answer(2, device.get(next[1]), 0, 0);
            next += 2;
        }
    }
    return std::fclose(device.answers) ? 2 : 0;
}

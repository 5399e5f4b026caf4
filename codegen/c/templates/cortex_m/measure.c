// Measures the core on a Cortex-M7 in QEMU: its recorded words, instructions of a frame, bytes of stack.
#include <stdio.h>
#include <string.h>

#include "$name.h"
#define main recorded_main
#include "../${name}_test.c"
#undef main

#define SYSTICK ((volatile uint32_t *)0xE000E010)
#define PAINT 0xA5A5A5A5u

extern uint32_t stack_bottom;

// Ticks of a loop of 200,000 instructions: QEMU counts instructions as time, SysTick counts that.
static uint32_t ticks_of_known(void)
{
    uint32_t left = 100000;
    SYSTICK[1] = 0xFFFFFF;
    SYSTICK[2] = 0;
    SYSTICK[0] = 5;
    __asm__ volatile("1: subs %0, %0, #1\n bne 1b" : "+r"(left)::"cc");
    return 0xFFFFFF - SYSTICK[2];
}

static ${name}_state own;
static ${name}_result answer;

int main(void)
{
    uint32_t least = UINT32_MAX, most = 0, marker = 0;
    if (recorded_main() != 0)
        return 1;
    ${name}_init(&own);
    for (volatile uint32_t *word = &stack_bottom; word < &marker - 64; word++)
        *word = PAINT;
    for (int frame = 0; frame < FRAMES; frame++) {
        SYSTICK[1] = 0xFFFFFF;
        SYSTICK[2] = 0;
        SYSTICK[0] = 5;
        ${name}_step(&own, codes[frame], &answer);
        const uint32_t ticks = 0xFFFFFF - SYSTICK[2];
        least = ticks < least ? ticks : least;
        most = ticks > most ? ticks : most;
    }
    const uint32_t *deepest = &stack_bottom;
    while (*deepest == PAINT)
        deepest++;
    const uint32_t one = 200000 / ticks_of_known();
    printf("%u to %u instructions, %u bytes of stack\n", (unsigned)(one * least), (unsigned)(one * most),
           (unsigned)((const char *)&marker - (const char *)deepest));
    return 0;
}

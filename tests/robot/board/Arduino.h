// The board as the tests see it: time that passes with every call, a scripted button, LED and USB.
#pragma once
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#define HIGH 1
#define LOW 0
#define OUTPUT 1
#define INPUT_PULLUP 2
#define LED_BUILTIN 32

struct Finished {};  // thrown when the script ends: the sketch itself never returns

uint32_t micros();
uint32_t millis();
void delay(uint32_t ms);
void pinMode(int pin, int mode);
void digitalWrite(int pin, int level);
int digitalRead(int pin);
void spend(uint64_t us);
[[noreturn]] void broken(const std::string &rule);

struct HardwareSerial {
  void begin(unsigned long) {}
  void print(const char *text);
  void print(char letter);
  void print(int number);
  void print(double number, int digits);
  void println(int number);
  void println(double number, int digits);
};
extern HardwareSerial Serial, Serial1;

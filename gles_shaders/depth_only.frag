#version 300 es
// SPDX-License-Identifier: MIT
// Nothing: depth is written without a shader's help.
precision mediump float;

void main() {}

export function plainTexts(strings: readonly string[]): string[];
export function isSentence(text: string): boolean;

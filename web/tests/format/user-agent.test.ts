import { browserName } from "../../src/format/user-agent.js";
import { describe, expect, test } from "vitest";

describe("browsers", () => {
test.each([
  ["Mozilla/5.0 (X11; Linux x86_64) AppleWebKit/537.36 (KHTML, like Gecko) Chrome/140.0 Safari/537.36", "Chrome on Linux"],
  ["Mozilla/5.0 (Windows NT 10.0) AppleWebKit/537.36 Chrome/140.0 Safari/537.36 Edg/140.0", "Edge on Windows"],
  ["Mozilla/5.0 (iPhone; CPU iPhone OS 18_0 like Mac OS X) AppleWebKit Version/18.0 Safari/604.1", "Safari on iPhone"],
  ["Mozilla/5.0 (X11; Linux x86_64; rv:140.0) Gecko/20100101 Firefox/140.0", "Firefox on Linux"],
  ["python-httpx/0.28", "python-httpx/0.28"],
  ["", "Unknown program"],
])("%s is called %s", (agent, words) => {
  expect(browserName(agent)).toBe(words);
});
});

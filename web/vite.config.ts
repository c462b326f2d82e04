import { createHash } from "node:crypto";
import { readdir, readFile, writeFile } from "node:fs/promises";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import type { Plugin, Rolldown } from "vite";
import { defineConfig } from "vitest/config";
import { catalogues } from "./catalogue/plugin.mjs";

const out = fileURLToPath(new URL("../src/talaia/web/static", import.meta.url));
const hub = process.env["TALAIA_HUB"] ?? "http://127.0.0.1:8765";
const compressible = /\.(js|css|svg|html|json)$/;
/** JavaScript a browser loads before the home page shows, gzip, in bytes. */
const FIRST_PAINT_LIMIT = 200_000;
/** The service worker; its name never changes, or browsers would not find the next version. */
const WORKER = "worker.js";
/** Of `public/`, what the offline page is made of. */
const PLAIN_SHELL = ["offline.html", "offline.css", "offline.js", "icon.svg"];
/** What stands around every page. */
const FRAME = "src/pages/shell/app.ts";
const FIRST_PAGES = [FRAME, "src/pages/sign-in/page-sign-in.ts", "src/pages/home/page-home.ts"];

/**
 * Few files instead of many small ones: a browser asks a hub for six at a time, and each round is a
 * way to the hub and back. What only some pages share stays in files of its own.
 */
const GROUPS = [
  // Words are made of it, and come before anything that has words in its constants.
  { name: "lit", test: /[\\/]node_modules[\\/]@?lit/, priority: 4 },
  { name: "words", test: /[\\/]src[\\/]words[\\/]language\.ts$/, priority: 3 },
  { name: "frame", test: (id: string) => id.endsWith(FRAME), priority: 2 },
  { name: "common", test: /[\\/]src[\\/]/, minShareCount: 10, priority: 1 },
];

/** Puts a .gz beside each text file, so that the hub compresses nothing while it serves. */
function precompress(): Plugin {
  return {
    name: "talaia-precompress",
    apply: "build",
    async closeBundle() {
      for (const entry of await readdir(out, { recursive: true })) {
        if (!compressible.test(entry)) continue;
        const path = join(out, entry);
        await writeFile(`${path}.gz`, gzipSync(await readFile(path), { level: 9 }));
      }
    },
  };
}

/** A name, and all that `next` leads to from it. */
function reachFrom(name: string, next: (name: string) => readonly string[], found = new Set<string>()): Set<string> {
  if (found.has(name)) return found;
  found.add(name);
  for (const other of next(name)) reachFrom(other, next, found);
  return found;
}

interface Chunk {
  readonly type: string;
  readonly imports?: readonly string[];
}

/** The files that come with each of these, in one set. */
function loadedWith(bundle: Readonly<Record<string, Chunk>>, files: readonly string[]): Set<string> {
  const found = new Set<string>();
  for (const file of files) reachFrom(file, (name) => bundle[name]?.imports ?? [], found);
  return found;
}

function holdsFirstPage(chunk: { readonly moduleIds: readonly string[] }): boolean {
  return chunk.moduleIds.some((id) => FIRST_PAGES.some((page) => id.endsWith(page)));
}

/** The scripts of which something is true. */
function scriptsWith(bundle: Rolldown.OutputBundle, isOne: (chunk: Rolldown.OutputChunk) => boolean): string[] {
  return Object.values(bundle).flatMap((file) => (file.type === "chunk" && isOne(file) ? [file.fileName] : []));
}

/** Prints what sign-in and home cost over the wire, and fails over the limit. */
function firstPaint(): Plugin {
  return {
    name: "talaia-first-paint",
    apply: "build",
    generateBundle(_options, bundle) {
      const first = loadedWith(bundle, scriptsWith(bundle, (chunk) => chunk.isEntry || holdsFirstPage(chunk)));
      const sizeOf = (file: string): number => (bundle[file]?.type === "chunk" ? gzipSync(bundle[file].code, { level: 9 }).length : 0);
      const total = [...first].reduce((sum, file) => sum + sizeOf(file), 0);
      const tell = (language: string, bytes: number, files: number): void => {
        console.log(
          `sign-in and home in ${language}: ${(bytes / 1000).toFixed(1)} kB of JavaScript (gzip) in ${String(files)} files; ` +
            `limit ${String(FIRST_PAINT_LIMIT / 1000)} kB`,
        );
        if (bytes > FIRST_PAINT_LIMIT) this.error("the first pages are over their limit");
      };
      tell("en", total, first.size);
      for (const chunk of Object.values(bundle)) {
        const language = chunk.type === "chunk" ? /virtual:catalogue\/(.+)\/first$/.exec(chunk.facadeModuleId ?? "")?.[1] : undefined;
        if (chunk.type !== "chunk" || language === undefined) continue;
        tell(language, total + sizeOf(chunk.fileName), first.size + 1);
      }
    },
  };
}

/**
 * Fails where a constant with words could be made before its words are there: with what is loaded
 * before all words, no other module may be loaded than those that it imports.
 */
function wordsFirst(): Plugin {
  return {
    name: "talaia-words-first",
    apply: "build",
    generateBundle(_options, bundle) {
      for (const chunk of Object.values(bundle)) {
        if (chunk.type !== "chunk") continue;
        const first = chunk.moduleIds.find((id) => /\/src\/main\.ts$|virtual:catalogue\/.+\/first$/.test(id) || id.endsWith(FRAME));
        if (first === undefined) continue;
        const imported = reachFrom(first, (id) => this.getModuleInfo(id)?.importedIds ?? []);
        for (const file of loadedWith(bundle, [chunk.fileName])) {
          const more = bundle[file]?.type === "chunk" ? bundle[file].moduleIds.find((id) => /\/src\/.*\.ts$/.test(id) && !imported.has(id)) : undefined;
          if (more !== undefined) this.error(`${file} comes with ${first} and has ${more}, whose words are not there yet`);
        }
      }
    },
  };
}

/** Lets browsers fetch the pages' frame while they still look which language is wanted. */
function preloadFrame(): Plugin {
  return {
    name: "talaia-preload-frame",
    apply: "build",
    transformIndexHtml: {
      order: "post",
      handler(_html, { bundle = {} }) {
        // What comes with the first file is announced by the builder itself.
        const announced = loadedWith(bundle, scriptsWith(bundle, ({ isEntry }) => isEntry));
        const files = loadedWith(bundle, scriptsWith(bundle, ({ moduleIds }) => moduleIds.some((id) => id.endsWith(FRAME))));
        return [...files].filter((file) => !announced.has(file)).map((file) => ({ tag: "link", attrs: { rel: "modulepreload", crossorigin: true, href: `/${file}` }, injectTo: "head" as const }));
      },
    },
  };
}

/** Tells the service worker which files to keep, and of which version they are. */
function fillWorker(): Plugin {
  return {
    name: "talaia-fill-worker",
    apply: "build",
    generateBundle: {
      order: "post",
      async handler(_options, bundle) {
        const worker = Object.values(bundle).find((file) => file.type === "chunk" && file.fileName === WORKER);
        if (worker?.type !== "chunk") return this.error("there is no service worker");
        if (worker.imports.length > 0) return this.error("the service worker is a script and imports nothing");
        const files = loadedWith(bundle, scriptsWith(bundle, (chunk) => chunk !== worker && (chunk.isEntry || holdsFirstPage(chunk))));
        for (const file of Object.values(bundle)) if (file.type === "asset" && file.fileName.endsWith(".css")) files.add(file.fileName);
        const version = createHash("sha256").update(worker.code);
        // Names of the others hold a hash already.
        for (const name of PLAIN_SHELL) version.update(await readFile(new URL(`public/${name}`, import.meta.url)));
        const paths = [...[...files].sort(), ...PLAIN_SHELL].map((file) => `/${file}`);
        version.update(paths.join("\n"));
        worker.code = worker.code
          .replace(/(["'`])__SHELL_FILES__\1/, () => JSON.stringify(JSON.stringify(paths)))
          .replace("__SHELL_VERSION__", version.digest("hex").slice(0, 12));
        if (worker.code.includes("__SHELL_")) return this.error("the service worker has no place for its files");
      },
    },
  };
}

export default defineConfig({
  build: {
    outDir: out,
    emptyOutDir: true,
    target: "es2022",
    // Data addresses are allowed for pictures only; scripts and styles stay files (CSP).
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    rolldownOptions: {
      input: { index: fileURLToPath(new URL("index.html", import.meta.url)), worker: fileURLToPath(new URL("src/worker/worker.ts", import.meta.url)) },
      output: {
        entryFileNames: ({ name }) => (name === "worker" ? WORKER : "assets/[name]-[hash].js"),
        codeSplitting: { groups: GROUPS },
      },
    },
  },
  plugins: [
    catalogues({ firstPages: FIRST_PAGES.map((page) => page.replace("src/", "")) }),
    preloadFrame(),
    fillWorker(),
    firstPaint(),
    wordsFirst(),
    precompress(),
  ],
  server: {
    host: "127.0.0.1",
    proxy: { "/api": hub, "/extensions": hub, "/ws": { target: hub.replace("http", "ws"), ws: true } },
  },
  test: {
    include: ["tests/**/*.test.ts"],
    environment: "node",
    // Files share their modules and their threads: to load all anew for each took six times as long.
    pool: "threads",
    isolate: false,
    testTimeout: 30_000,
    // Held by tools/coverage_floors.json.
    coverage: { provider: "v8", include: ["src/**/*.ts"], reporter: ["json-summary"] },
  },
});

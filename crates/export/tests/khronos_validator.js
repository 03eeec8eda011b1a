// Validates files with the glTF validator.
// Arguments: the folder the package is installed in, then the files. Prints one JSON row a file.
'use strict';

const fs = require('fs');
const path = require('path');

const [folder, ...files] = process.argv.slice(2);
const validator = require(path.join(folder, 'node_modules', 'gltf-validator'));

async function main() {
  for (const file of files) {
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {
      uri: path.basename(file),
      format: path.extname(file).slice(1),
      maxIssues: 0,
      externalResourceFunction: async (uri) =>
        new Uint8Array(fs.readFileSync(path.join(path.dirname(file), decodeURIComponent(uri)))),
    });
    const { numErrors, numWarnings, messages } = report.issues;
    const { totalVertexCount, totalTriangleCount } = report.info;
    console.log(
      JSON.stringify({ file, numErrors, numWarnings, totalVertexCount, totalTriangleCount, messages })
    );
  }
}

main().catch((error) => {
  console.error(error);
  process.exit(1);
});
